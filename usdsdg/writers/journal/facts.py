"""What a run tells of itself while it goes on: the assets that it reads, its writers, and its settings.

Facts have two levels, as {"assets": {name: {...}}}; those of parts and of runs that went on are joined.
"""

from __future__ import annotations

import os
import sys
import tempfile
import threading
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from types import ModuleType
from typing import Any

from pxr import Ar, Sdf, Usd

from usdsdg.errors import AssetUnreadable
from usdsdg.stage.assets import anchors
from usdsdg.stage.assets.file_checks import check_regular
from usdsdg.stage.assets.opened import last_note, opened_since
from usdsdg.stores.whole_file import facts_of

ASSETS, WRITERS, SETTINGS = "assets", "writers", "settings"
Facts = dict[str, dict[str, Any]]
# Keys of a layer's customLayerData that tell where an asset comes from.
_TOLD = ("source", "license")
# Settings that say where files go, or how fast they are written.
_PLACES = ("/omni/replicator/backends/", "/omni/replicator/backend/", "/usdsdg/writers/", "/app/", "/log/", "/exts/")


def joined(facts: Iterable[Mapping[str, Mapping[str, Any]]]) -> Facts:
    """Return several facts as one; later ones replace earlier ones."""
    found: Facts = {}
    for each in facts:
        for section, values in each.items():
            found.setdefault(section, {}).update(values)
    return {section: dict(sorted(values.items())) for section, values in sorted(found.items())}


class AssetFacts:
    """The assets that a run has read, and the modules of its script; hashes are computed on a thread of their own.

    Attributes:
        source: the script or configuration; None: there is none.
    """

    def __init__(self, note: int) -> None:
        """note: the last one of files that were read before, by what else this process did."""
        self.source: Path | None = None
        self._modules = 0  # how many were imported when those of the script were looked for last
        self._seen: set[str] = set()  # files
        self._note = note
        self._open: list[Future[tuple[str, dict[str, Any]] | None]] = []
        self._pool: ThreadPoolExecutor | None = None
        self._lock = threading.Lock()

    def see(self, stage: Usd.Stage) -> None:
        """Note the layers of a stage."""
        for layer in stage.GetUsedLayers():
            if layer.realPath:
                self._add(layer.realPath, layer)

    def take(self) -> dict[str, Any]:
        """Return, once, what is known of the assets that were noted, and of files that were read; waits for hashes.

        Pictures may be traced after their frame was captured, so their textures are known when their files are whole.
        """
        note, self._note = self._note, last_note()
        for path in opened_since(note):
            self._add(path, None)
        if len(sys.modules) != self._modules:
            self._modules = len(sys.modules)
            for path in _modules_beside(self.source):
                self._add(path, None)
        with self._lock:
            open_, self._open = self._open, []
        return dict(found for future in open_ if (found := future.result()) is not None)

    def _add(self, path: str, layer: Sdf.Layer | None) -> None:
        if path in self._seen:
            return
        self._seen.add(path)
        root = anchors.assets_root_of(path)  # also where a run fails before it has seen a stage
        if self._pool is None:
            self._pool = ThreadPoolExecutor(1, thread_name_prefix="usdsdg-assets")
        told = {} if layer is None else _told(layer)
        beside = self.source.parent if self.source is not None else None
        try:
            future = self._pool.submit(_asset, path, root, beside, told)
        except RuntimeError:  # when the program ends, threads take no more work
            future = Future()
            future.set_result(_asset(path, root, beside, told))
        with self._lock:
            self._open.append(future)


def _modules_beside(source: Path | None) -> Iterator[str]:
    """Yield the files of the modules in the folder of a script, and below, that were imported until now."""
    if source is None or source.suffix != ".py":
        return
    top, started_in = os.path.join(source.parent, ""), sys.modules["usdsdg"]._STARTED_IN  # which a script may leave
    # A copy in one step: other threads import modules, also while a tuple of the items is filled.
    for name, module in sys.modules.copy().items():
        file = vars(module).get("__file__") if isinstance(module, ModuleType) else None
        if not isinstance(file, str) or not file.endswith(".py") or name.startswith("usdsdg"):
            continue
        path = file if os.path.isabs(file) else os.path.normpath(os.path.join(started_in, file))
        if path.startswith(top) and path != str(source) and not _is_installed(Path(path)):
            yield path


def _is_installed(path: Path) -> bool:
    return "site-packages" in path.parts or any(path.is_relative_to(each) for each in (sys.prefix, sys.base_prefix))


def _asset(path: str, root: str, beside: Path | None, told: dict[str, Any]) -> tuple[str, dict[str, Any]] | None:
    """Return the name and hash of an asset, and what is known of it; None where no file is.

    Below the assets root the name is the path there, else that of the file alone, with a path of its own.
    beside: the folder of the script or configuration.
    """
    file = Path(Ar.SplitPackageRelativePathOuter(path)[0] if "[" in path else path)
    try:
        check_regular(str(file))
        size, sha256 = facts_of(file)
    except (OSError, AssetUnreadable):
        return None
    if root and file.is_relative_to(root):
        name = f"/{file.relative_to(root).as_posix()}"
        return f"{name} {sha256}", {"name": name, "size": size, "sha256": sha256, **told}
    where = _lasting_path(file, beside)
    facts = {"name": file.name, "size": size, "sha256": sha256, **({"path": where} if where else {}), **told}
    return f"{file.name} {sha256}{f' {where}' if where else ''}", facts


def _lasting_path(file: Path, beside: Path | None) -> str:
    """Return the path of a file that has it in another process, too: from the folder of the script, or a portable one.

    It is "" for a temporary file, and for one of the cache, which has another path for other content.
    """
    if beside is not None and file.is_relative_to(beside):
        return file.relative_to(beside).as_posix()
    found = anchors.portable(os.fspath(file))
    return "" if found.startswith(anchors.CACHE) or file.is_relative_to(tempfile.gettempdir()) else found


def _told(layer: Sdf.Layer) -> dict[str, Any]:
    data = layer.customLayerData
    return {key: str(data[key]) for key in _TOLD if data.get(key)}


def changed_assets(known: Mapping[str, Any], new: Mapping[str, Any]) -> list[str]:
    """Return the assets, by name or path, that have other content than what is known of them.

    The name alone of one outside of the assets root, which several files may have, tells nothing.
    """
    places = {place for each in known.values() if (place := _place(each))}
    changed = {place for key, each in new.items() if key not in known and (place := _place(each)) in places}
    return sorted(changed)


def assets_of_two_contents(known: Mapping[str, Any]) -> list[str]:
    """Return the assets, by name or path, of which frames of one dataset had more than one content."""
    found: dict[str, set[Any]] = defaultdict(set)
    for each in known.values():
        found[_place(each)].add(each.get("sha256"))
    return sorted(place for place, contents in found.items() if place and len(contents) > 1)


def _place(asset: Mapping[str, Any]) -> str:
    """Return what tells an asset from others: its name below the assets root, or its path; "" if neither is known."""
    name = str(asset.get("name", ""))
    return name if name.startswith("/") else str(asset.get("path", ""))


def settings_facts(changed: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings that decide what is made, of those that were changed."""
    return {name: plain(value) for name, value in sorted(changed.items()) if not name.startswith(_PLACES)}


def plain(value: Any) -> Any:
    """Return a value as JSON has it, with portable paths; of objects that it has not, the name of their type."""
    return anchors.portable_value(value, key=str, other=_of_json)


def _of_json(value: Any) -> Any:
    if value is None or isinstance(value, (bool, int, float)):
        return value
    return plain(value.tolist()) if hasattr(value, "tolist") else f"<{type(value).__name__}>"
