"""The scripts of all prims: those that `omni:scripting:scripts` names, called as the timeline goes on."""

from __future__ import annotations

import importlib.util
import inspect
import itertools
import sys
from dataclasses import dataclass
from types import ModuleType

from pxr import Sdf, Tf, Usd

from usdsdg.app.app import get_app
from usdsdg.compat.omni.behavior.scripting.behavior_script import BehaviorScript
from usdsdg.errors import AssetUnreadable, warn_once
from usdsdg.session import stage_context
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline
from usdsdg.stage import assets

SCRIPTS = "omni:scripting:scripts"
CONSENT = "/app/scripting/ignoreWarningDialog"

_EVENTS = {"play": "on_play", "pause": "on_pause", "stop": "on_stop"}
_module_numbers = itertools.count()


@dataclass(frozen=True, eq=False)
class AttachedFile:
    """A script file on a prim and the scripts that it made there."""

    asset_path: str  # as authored
    scripts: tuple[BehaviorScript, ...]


class ScriptManager:
    """Follows the attribute `omni:scripting:scripts` of the current stage.

    Changes take effect at the next application update, or when the timeline begins to play. An exception of a script
    is raised from there. Files run if the running program has named them, by setting the attribute; those that a file
    or asset brings along run only if the setting `/app/scripting/ignoreWarningDialog` is true, which stands for the
    answer to Kit's question.
    """

    def __init__(self) -> None:
        self._attached: dict[Sdf.Path, list[AttachedFile]] = {}
        self._modules: dict[str, ModuleType] = {}
        self._named: set[str] = set()  # asset paths that the program itself has set
        self._playing = get_timeline().is_playing()  # whether the scripts have been told
        self._follow(current().stage)
        stage_context.on_stage_closing(self._on_closing)
        stage_context.on_new_stage(self._on_new_stage)
        get_timeline().subscribe(self._on_timeline)
        get_app().subscribe_update(lambda _dt: self.refresh())

    def scripts(self, prim_path: Sdf.Path | str) -> list[BehaviorScript]:
        """Return the scripts that run on a prim, in the order of the attribute."""
        files = self._attached.get(Sdf.Path(str(prim_path)), [])
        return [script for file in files for script in file.scripts]

    def refresh(self) -> None:
        """Attach and take off scripts as the stage says now."""
        edited, resynced = self._edited, self._resynced
        if not edited and not resynced:
            return
        self._edited, self._resynced = set(), set()
        if (stage := self._stage) is None:
            return
        for path in edited:
            self._named.update(_asset_paths(stage.GetPrimAtPath(path)))
        paths = set(edited)
        for root in Sdf.Path.RemoveDescendentPaths(sorted(resynced)):
            paths.update(path for path in self._attached if path.HasPrefix(root))
            if start := stage.GetPrimAtPath(root):
                below = (prim for prim in Usd.PrimRange(start) if not prim.IsPseudoRoot())
                paths.update(prim.GetPath() for prim in below if prim.HasAttribute(SCRIPTS))
        for path in sorted(paths):
            self._attach(path, _asset_paths(stage.GetPrimAtPath(path)))

    # --- following the stage and the timeline ---
    def _follow(self, stage: Usd.Stage | None) -> None:
        self._stage = stage
        self._edited: set[Sdf.Path] = set()
        self._resynced: set[Sdf.Path] = {Sdf.Path.absoluteRootPath}
        self._listener = stage and Tf.Notice.Register(Usd.Notice.ObjectsChanged, self._record, stage)

    def _record(self, notice: Usd.Notice.ObjectsChanged, _stage: Usd.Stage) -> None:
        for path in (*notice.GetChangedInfoOnlyPaths(), *notice.GetResyncedPaths()):
            if path.IsAbsoluteRootOrPrimPath():
                self._resynced.add(path)
            elif path.name == SCRIPTS:
                self._edited.add(path.GetPrimPath())

    def _on_closing(self, stage: Usd.Stage) -> None:
        """End all scripts while their prims are still there, those of a timeline that plays after its stop."""
        get_timeline().stop()
        for path in sorted(self._attached):
            self._attach(path, [])

    def _on_new_stage(self, stage: Usd.Stage) -> None:
        self._modules.clear()
        self._named.clear()
        self._follow(stage)

    def _on_timeline(self, event: str) -> None:
        if event == "play":
            self.refresh()
        self._playing = event in ("play", "tick", "loop")
        running = [script for path in sorted(self._attached) for script in self.scripts(path)]
        timeline = get_timeline()
        for script in running:
            if event == "tick":
                script.on_update(timeline.get_current_time(), timeline.latest_advance)
            elif event in _EVENTS:
                getattr(script, _EVENTS[event])()

    # --- one prim ---
    def _attach(self, path: Sdf.Path, wanted: list[str]) -> None:
        """Make the files of a prim those in `wanted`; files that stay keep their scripts."""
        before, after = list(self._attached.get(path, [])), []
        missing = []
        for asset_path in wanted:
            kept = next((file for file in before if file.asset_path == asset_path), None)
            if kept is not None:
                before.remove(kept)
            after.append(kept or AttachedFile(asset_path, ()))
            if kept is None and self._may_run(path, asset_path):
                missing.append(len(after) - 1)
        self._attached[path] = after
        if not after:
            del self._attached[path]
        for file in before:
            for script in file.scripts:
                script.on_destroy()
        for index in missing:
            after[index] = AttachedFile(after[index].asset_path, self._start(path, after[index].asset_path))

    def _may_run(self, path: Sdf.Path, asset_path: str) -> bool:
        if asset_path in self._named or get_settings().get_as_bool(CONSENT):
            return True
        warn_once(
            f"{path} names the script {asset_path}, which was not run, because it comes with the stage. To run the "
            f'scripts of a stage, set "{CONSENT}" to true before opening it.'
        )
        return False

    def _start(self, path: Sdf.Path, asset_path: str) -> tuple[BehaviorScript, ...]:
        scripts = tuple(make(path) for make in _classes(self._module(path, asset_path)))
        for script in scripts:
            script.on_init()
            if self._playing:
                script.on_play()
        return scripts

    def _module(self, path: Sdf.Path, asset_path: str) -> ModuleType:
        if asset_path not in self._modules:
            file = self._file(path, asset_path)
            name = f"behavior_script_{next(_module_numbers)}"
            spec = importlib.util.spec_from_file_location(name, file)
            if spec is None or spec.loader is None:
                raise AssetUnreadable(f"{path}: the script {file} is not a Python file")
            self._modules[asset_path] = sys.modules[name] = module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
        return self._modules[asset_path]

    def _file(self, path: Sdf.Path, asset_path: str) -> str:
        """Return the file of a script; relative paths are relative to the layer that names it."""
        assert self._stage is not None
        authored = self._stage.GetPrimAtPath(path).GetAttribute(SCRIPTS).Get() or []
        found = [asset.resolvedPath for asset in authored if asset.path == asset_path and asset.resolvedPath]
        return found[0] if found else assets.resolve(asset_path)


def _asset_paths(prim: Usd.Prim) -> list[str]:
    attribute = prim.GetAttribute(SCRIPTS) if prim else None
    return [asset.path for asset in (attribute.Get() or [])] if attribute else []


def _classes(module: ModuleType) -> list[type[BehaviorScript]]:
    """Return the script classes of a file, without those that only serve others there as a base."""
    found = [
        each
        for _, each in inspect.getmembers(module, inspect.isclass)
        if issubclass(each, BehaviorScript) and each is not BehaviorScript
    ]
    return [each for each in found if not any(each is not other and issubclass(other, each) for other in found)]


def get_script_manager() -> ScriptManager:
    """Return the script manager of the session."""
    return current().script_manager
