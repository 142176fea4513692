"""The current stage: create, open and save it, and look stages up by id."""

import os
from collections.abc import Callable
from pathlib import Path

from pxr import Sdf, Tf, Usd, UsdUtils

from usdsdg import errors
from usdsdg.session import new_stages, stage_times
from usdsdg.session.new_stages import NewStage
from usdsdg.session.session import current
from usdsdg.session.turns import in_turn
from usdsdg.stage import assets, flatten, schemas
from usdsdg.stage.cameras import viewport_cameras
from usdsdg.stage.usd_errors import reason

schemas.register()


def current_stage() -> Usd.Stage:
    """Return the stage that scripts and engines share; a new one if there is none yet."""
    stage = current().stage
    return new_stage() if stage is None else stage


@in_turn
def new_stage() -> Usd.Stage:
    """Create a stage in memory and make it current: Z up, meters, 60 time codes per second, /World.

    Where `use_new_stages` has chosen another kind, it is of that kind.
    """
    stage = Usd.Stage.CreateInMemory()
    new_stages.author(stage, current().new_stage_kind)
    return set_stage(stage)


def show_viewport() -> None:
    """Give the current stage and every later one the cameras of the application's viewport."""
    session = current()
    session.has_viewport = True
    if session.stage is not None:
        viewport_cameras.author(session.stage)


def use_new_stages(kind: NewStage) -> None:
    """Choose what every later `new_stage` holds."""
    current().new_stage_kind = kind


def open_at_start(path: str | os.PathLike[str]) -> Usd.Stage:
    """Open the stage that a script finds open when it starts, as in the GUI.

    Raises:
        as `open_stage`.
    """
    current().opened_stage = open_stage(path)
    return current().opened_stage


def stage_at_start() -> Usd.Stage:
    """Return the stage of a new application: the one of `open_at_start` while it is current, else a new one."""
    session = current()
    if session.opened_stage is not None and session.stage == session.opened_stage:
        return session.opened_stage
    return new_stage()


@in_turn
def open_stage(path: str | os.PathLike[str]) -> Usd.Stage:
    """Open a file and make it the current stage; `path` may be a URL under the assets root.

    Unsaved edits from an earlier use of the file in this process are discarded, and files that have changed since are
    read again.

    Raises:
        AssetNotFound: no such file.
        AssetUnreadable: the file is not USD, or it is damaged.
        BadValue: its time codes are not finite, or their rate is not above 0.
    """
    file = assets.resolve(os.fspath(path))
    if os.path.isdir(file):
        raise errors.AssetUnreadable(f"{file} cannot be opened as a stage: it is a folder")
    assets.check_file(file)
    try:
        layer = Sdf.Layer.FindOrOpen(file)
        if layer is None:  # for which pxr reports no reason
            raise errors.AssetUnreadable(f"{file} cannot be opened as a stage: {assets.why_no_layer(file)}")
        if layer == _root_layer():
            current().timeline.stop()  # or physics would restore its opinions of the discarded layer
        layer.Reload(force=layer.dirty)
        assets.check_neighbors(layer)
        stage = Usd.Stage.Open(layer)
        stage.Reload()  # sublayers and references that earlier stages have left open
    except Tf.ErrorException as failure:
        why = assets.not_a_file_of_its_own(file)
        why = f"it {why}" if why else reason(failure)
        raise errors.AssetUnreadable(f"{file} cannot be opened as a stage: {why}") from failure
    stage_times.of_stage(stage)  # or the stage before it were gone
    assets.redirect(stage)
    return set_stage(stage)


def _root_layer() -> Sdf.Layer | None:
    stage = current().stage
    return stage.GetRootLayer() if stage is not None else None


@in_turn
def set_stage(stage: Usd.Stage) -> Usd.Stage:
    """Make `stage` the current one, reset the state of the previous one, and call the `on_new_stage` callbacks.

    A timeline that plays is stopped first, while the previous stage is still there to be restored.
    """
    session, cache = current(), UsdUtils.StageCache.Get()
    if session.stage == stage:
        return stage
    if session.stage is not None:
        session.closing_listeners.call(session.stage)
        session.timeline.stop()
        cache.Erase(session.stage)
    cache.Insert(stage)
    session.stage = stage
    session.begin_stage(stage)
    return stage


def on_new_stage(callback: Callable[[Usd.Stage], None]) -> Callable[[], None]:
    """Call `callback(stage)` whenever another stage becomes the current one; return the unsubscriber."""
    return current().stage_listeners.subscribe(callback)


def on_stage_closing(callback: Callable[[Usd.Stage], None]) -> Callable[[], None]:
    """Call `callback(stage)` before another stage becomes the current one; return the unsubscriber."""
    return current().closing_listeners.subscribe(callback)


def assets_root() -> str:
    """Return the folder that holds the assets `Isaac` and `NVIDIA`: set, from the environment, or the demo assets.

    Raises:
        AssetNotFound: the folder does not exist.
    """
    return assets.assets_root()  # the session has registered the demo assets


def stage_id() -> int:
    """Return the id of the current stage in USD's stage cache, as `omni.usd` does."""
    return UsdUtils.StageCache.Get().GetId(current_stage()).ToLongInt()


def stage_by_id(identifier: int) -> Usd.Stage:
    """Return the stage with an id from `stage_id`.

    Raises:
        StageError: no open stage has this id; another stage may have replaced it.
    """
    stage = UsdUtils.StageCache.Get().Find(Usd.StageCache.Id.FromLongInt(int(identifier)))
    if not stage:
        raise errors.StageError(
            f"no open stage has id {identifier}; the current one has {stage_id()}. "
            "Ask for the id again after new_stage or open_stage."
        )
    return stage


def save_stage(path: str | os.PathLike[str]) -> Path:
    """Write the current stage as one file that usdview and Isaac Sim open; return its absolute path.

    Root layer, sublayers and session layer become one layer. References stay references and still resolve
    from the new location. The file is written atomically.

    Raises:
        Unsupported: the extension is not .usd, .usda or .usdc.
        OutputNotWritable: the folder or file cannot be written.
    """
    file = Path(path).absolute()
    flatten.check_writable(file)
    return flatten.write_layer(snapshot(file.parent), file)


@in_turn
def snapshot(folder: Path) -> Sdf.Layer:
    """Return the current stage as one layer, with asset paths relative to `folder`."""
    current().orchestrator.author_run(current_stage())
    layer = flatten.flattened(current_stage(), folder)
    # Of a copy: an Isaac Sim camera that is garbage collected meanwhile takes its product away.
    products = list(current().render_products.values())
    viewport_cameras.remove(layer, keep={product.camera_path for product in products})
    return layer
