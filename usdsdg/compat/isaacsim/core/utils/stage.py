"""`isaacsim.core.utils.stage`: create, open, save and reference into the current stage."""

from __future__ import annotations

from pxr import Usd, UsdGeom

from usdsdg.app.app import get_app
from usdsdg.errors import AssetError
from usdsdg.session import stage_context
from usdsdg.stage import assets

__all__ = [
    "add_reference_to_stage", "create_new_stage", "get_current_stage", "get_stage_units", "get_stage_up_axis",
    "is_stage_loading", "open_stage", "save_stage", "set_stage_units", "set_stage_up_axis", "update_stage",
]  # fmt: skip


def get_current_stage(fabric: bool = False) -> Usd.Stage:
    return stage_context.current_stage()


def create_new_stage() -> bool:
    stage_context.new_stage()
    return True


def open_stage(usd_path: str) -> bool:
    """Open a file, or a URL under the assets root.

    Raises:
        AssetError: the file is missing or cannot be read.
    """
    stage_context.open_stage(usd_path)
    return True


def save_stage(usd_path: str, save_and_reload_in_place: bool = True) -> bool:
    stage_context.save_stage(usd_path)
    return True


def add_reference_to_stage(usd_path: str, prim_path: str, prim_type: str = "Xform") -> Usd.Prim:
    """Reference a file, or a URL under the assets root, on the prim at `prim_path`; define the prim if there is none.

    Raises:
        AssetError: the file is missing or cannot be referenced.
    """
    stage = stage_context.current_stage()
    prim = stage.GetPrimAtPath(prim_path) or stage.DefinePrim(prim_path, prim_type)
    file = assets.resolve(usd_path)
    if not prim.GetReferences().AddReference(file):
        raise AssetError(f"{file} cannot be referenced at {prim_path}")
    return prim


def is_stage_loading() -> bool:
    """Return False: loading is synchronous."""
    return False


def update_stage() -> None:
    """Run one app update."""
    get_app().update()


def get_stage_up_axis() -> str:
    return str(UsdGeom.GetStageUpAxis(stage_context.current_stage()))


def set_stage_up_axis(axis: str = "z") -> None:
    UsdGeom.SetStageUpAxis(stage_context.current_stage(), axis.upper())


def get_stage_units() -> float:
    """Return meters per stage unit."""
    return UsdGeom.GetStageMetersPerUnit(stage_context.current_stage())


def set_stage_units(stage_units_in_meters: float) -> None:
    UsdGeom.SetStageMetersPerUnit(stage_context.current_stage(), float(stage_units_in_meters))
