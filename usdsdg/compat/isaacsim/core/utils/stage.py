"""`isaacsim.core.utils.stage`: create, open, save, clear and reference into the current stage."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from pxr import Usd, UsdGeom

from usdsdg.app.app import get_app
from usdsdg.compat import used_stage
from usdsdg.compat.stage_events import stage_events
from usdsdg.compat.usdrt import Usd as usdrt_Usd
from usdsdg.compat.wrappers.prim_paths import existing_prim
from usdsdg.errors import AssetError
from usdsdg.session import stage_context
from usdsdg.stage import assets
from usdsdg.stage.paths import next_free_path

use_stage = used_stage.use_stage


# --- stages ---
def get_current_stage(fabric: bool = False) -> Any:
    """Return the stage, with `fabric` as `usdrt.Usd.Stage`."""
    stage = used_stage.current_stage()
    return usdrt_Usd.Stage(stage) if fabric else stage


def get_current_stage_id() -> int:
    return used_stage.stage_id(used_stage.current_stage())


def create_new_stage() -> bool:
    stage_context.new_stage()
    return True


async def create_new_stage_async() -> None:
    stage_context.new_stage()


def create_new_stage_in_memory() -> Usd.Stage:
    """Return an empty stage that is not made current."""
    return Usd.Stage.CreateInMemory()


def open_stage(usd_path: str) -> bool:
    """Open a file, or a URL under the assets root.

    Raises:
        AssetError: the file is missing or cannot be read.
    """
    stage_context.open_stage(usd_path)
    return True


async def open_stage_async(usd_path: str) -> tuple[bool, str]:
    """Open a file; return (True, no error)."""
    return open_stage(usd_path), ""


def save_stage(usd_path: str, save_and_reload_in_place: bool = True) -> bool:
    with stage_events().saving(usd_path):
        used_stage.save(usd_path)
    return True


def close_stage(callback_fn: Callable[[bool, str], object] | None = None) -> bool:
    """Replace the current stage by an empty one; `callback_fn(True, "")` follows."""
    stage_context.new_stage()
    if callback_fn is not None:
        callback_fn(True, "")
    return True


def is_stage_loading() -> bool:
    """Return False: loading is synchronous."""
    return False


def update_stage() -> None:
    """Run one app update."""
    get_app().update()


async def update_stage_async() -> None:
    """Wait for one app update."""
    await get_app().next_update_async()


# --- prims ---
def add_reference_to_stage(usd_path: str, prim_path: str, prim_type: str = "Xform") -> Usd.Prim:
    """Reference a file, or a URL under the assets root, on the prim at `prim_path`; define the prim if there is none.

    Raises:
        AssetError: the file is missing or cannot be referenced.
    """
    stage = used_stage.current_stage()
    file = assets.resolve_reference(usd_path, prim_path) if usd_path else None
    prim = stage.GetPrimAtPath(prim_path) or stage.DefinePrim(prim_path, prim_type)
    if file is None:
        return prim
    if not prim.GetReferences().AddReference(file):
        raise AssetError(f"{file} cannot be referenced at {prim_path}")
    return prim


def traverse_stage(fabric: bool = False) -> Iterator[Usd.Prim]:
    """Return the prims of the stage, in its order."""
    return iter(used_stage.current_stage().Traverse())


def print_stage_prim_paths(fabric: bool = False) -> None:
    for prim in traverse_stage():
        print(prim.GetPath())


def clear_stage(predicate: Callable[[str], bool] | None = None) -> None:
    """Remove the prims for whose path `predicate` holds; without one all but those of the renderer."""
    stage = used_stage.current_stage()
    keep = ("/Render", "/OmniverseKit", "/Replicator")
    paths = [str(prim.GetPath()) for prim in Usd.PrimRange.AllPrims(stage.GetPseudoRoot()) if not prim.IsPseudoRoot()]
    for path in paths:
        wanted = predicate(path) if predicate is not None else not path.startswith(keep)
        if wanted and stage.GetPrimAtPath(path):
            remove_prim(stage.GetPrimAtPath(path))


def remove_prim(prim: Usd.Prim) -> bool:
    """Remove a prim; turn off one that a reference or another layer brings. Return whether it is gone."""
    stage, path = prim.GetStage(), prim.GetPath()
    stage.RemovePrim(path)
    left = stage.GetPrimAtPath(path)
    if left and left.IsActive():
        left.SetActive(False)
    return not stage.GetPrimAtPath(path)


def get_next_free_path(path: str, parent: str | None = None) -> str:
    """Return the path, below `parent` or the default prim, with a number if there is a prim already."""
    if parent is not None:
        path = f"{existing_prim(parent).GetPath()}/{path.lstrip('/')}".replace("//", "/")
    return next_free_path(used_stage.current_stage(), path, parent is None)


# --- units ---
def get_stage_up_axis() -> str:
    return str(UsdGeom.GetStageUpAxis(used_stage.current_stage()))


def set_stage_up_axis(axis: str = "z") -> None:
    UsdGeom.SetStageUpAxis(used_stage.current_stage(), axis.upper())


def get_stage_units() -> float:
    """Return meters per stage unit."""
    return UsdGeom.GetStageMetersPerUnit(used_stage.current_stage())


def set_stage_units(stage_units_in_meters: float) -> None:
    UsdGeom.SetStageMetersPerUnit(used_stage.current_stage(), float(stage_units_in_meters))
