"""`isaacsim.core.experimental.utils.stage`: the current stage, its files, units, time codes and prims."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pxr import Sdf, Usd, UsdGeom, UsdPhysics

from usdsdg.compat import prim_moves, used_stage
from usdsdg.compat.isaacsim.core.experimental.utils.backend import get_current_backend
from usdsdg.compat.isaacsim.core.experimental.utils.prim import set_prim_variants
from usdsdg.compat.isaacsim.core.utils import stage as older
from usdsdg.compat.stage_events import stage_events
from usdsdg.compat.usdrt import Usd as usdrt_Usd
from usdsdg.compat.wrappers.prim_paths import existing_prim
from usdsdg.errors import BadPrim, Unsupported
from usdsdg.session import stage_context
from usdsdg.session.new_stages import DEFAULT_LIGHT, NewStage, add_light
from usdsdg.stage.paths import next_free_path

_BACKENDS = ("usd", "usdrt", "fabric")
is_stage_loading = older.is_stage_loading
get_stage_id, is_stage_set, use_stage = used_stage.stage_id, used_stage.is_stage_set, used_stage.use_stage


# --- which stage ---
def get_current_stage(*, backend: str | None = None) -> Any:
    """Return the current stage, or with the backends "usdrt" and "fabric" that stage as `usdrt.Usd.Stage`.

    `backend` is by default that of the `use_backend` block.

    Raises:
        ValueError: there is no such backend for stages.
    """
    stage = used_stage.current_stage()
    chosen = get_current_backend(_BACKENDS) if backend is None else backend
    if chosen not in _BACKENDS:
        raise ValueError(f"there is no backend {backend!r} for stages; backends are {', '.join(_BACKENDS)}")
    return stage if chosen == "usd" else usdrt_Usd.Stage(stage)


def create_new_stage(*, template: str | None = None) -> Usd.Stage:
    """Create a stage and make it current: an empty one, or with the template "sunlight" one with a distant light.

    Raises:
        Unsupported: another template than "empty" and "sunlight".
    """
    if template not in (None, "empty", "sunlight"):
        raise Unsupported(
            f"create_new_stage: there is no template {template!r}, but 'empty' and 'sunlight'; add a ground plane and "
            "a light yourself"
        )
    stage = stage_context.new_stage()
    if template == "sunlight" and not stage.GetPrimAtPath(DEFAULT_LIGHT):
        add_light(stage, NewStage.ISAAC)
    return stage


async def create_new_stage_async(*, template: str | None = None) -> Usd.Stage:
    return create_new_stage(template=template)


def open_stage(usd_path: str) -> tuple[bool, Usd.Stage | None]:
    """Open a file, or a URL under the assets root; return (True, the stage).

    Raises:
        AssetError: the file is missing or cannot be read.
        ValueError: its name is not that of a USD file.
    """
    _check_name(usd_path)
    return True, stage_context.open_stage(usd_path)


async def open_stage_async(usd_path: str) -> tuple[bool, Usd.Stage | None]:
    return open_stage(usd_path)


def save_stage(usd_path: str) -> bool:
    """Write the current stage to a file."""
    _check_name(usd_path)
    with stage_events().saving(usd_path):
        used_stage.save(usd_path)
    return True


def close_stage() -> bool:
    """Replace the current stage by an empty one."""
    stage_context.new_stage()
    return True


# --- what is on it ---
def add_reference_to_stage(
    usd_path: str, path: str, *, prim_type: str = "Xform", variants: Sequence[tuple[str, str]] | None = None
) -> Usd.Prim:
    """Reference a file, or a URL under the assets root, on the prim at `path`, and select variants (set, variant).

    Raises:
        AssetError: the file is missing or cannot be referenced.
        ValueError: `path` is no path, or the prim has no such variant.
    """
    _check_path(path)
    prim = older.add_reference_to_stage(usd_path, path, prim_type)
    set_prim_variants(prim, variants=variants or ())
    return prim


def define_prim(path: str, type_name: str = "Xform") -> Usd.Prim:
    """Return the prim of this path and type; it is defined if there is none.

    Raises:
        RuntimeError: there is a prim of another type.
        ValueError: `path` is no absolute path.
    """
    _check_path(path)
    prim = used_stage.current_stage().GetPrimAtPath(path)
    if not prim:
        return used_stage.current_stage().DefinePrim(path, type_name)
    if prim.GetTypeName() != type_name:
        raise RuntimeError(f"{path} is a {prim.GetTypeName() or 'prim without a type'} already, not a {type_name}")
    return prim


def delete_prim(prim: str | Usd.Prim) -> bool:
    """Remove a prim; one that a reference brings is turned off. Return whether it is gone.

    Raises:
        BadPrim: there is no such prim.
    """
    return older.remove_prim(existing_prim(prim))


def move_prim(target: str | Usd.Prim, destination: str | Usd.Prim) -> tuple[bool, str]:
    """Move a prim to another path, or below the prim of that path; return (whether it moved, the new path).

    Raises:
        BadPrim: there is no such prim, or no parent for it.
    """
    prim = existing_prim(target)
    path = destination.GetPath() if isinstance(destination, Usd.Prim) else Sdf.Path(destination)
    stage = prim.GetStage()
    if stage.GetPrimAtPath(path):
        path = path.AppendChild(prim.GetName())
    elif not stage.GetPrimAtPath(path.GetParentPath()):
        raise BadPrim(f"{prim.GetPath()} cannot be moved to {path}: there is no prim at {path.GetParentPath()}")
    return prim_moves.move(stage, prim.GetPath(), path), str(path)


def generate_next_free_path(path: str | None = None, *, prepend_default_prim: bool = True) -> str:
    """Return the path, with a number if there is a prim already; "Prim" if none is given."""
    return next_free_path(
        used_stage.current_stage(), path if path not in (None, "", "/") else "Prim", prepend_default_prim
    )


def generate_stage_representation(mode: str = "tree") -> str:
    """Return the prims with their types as text: a "tree", or a "list" of paths.

    Raises:
        ValueError: there is no such mode.
    """
    if mode not in ("tree", "list"):
        raise ValueError(f"there is no mode {mode!r}; give 'tree' or 'list'")
    lines = []
    for prim in used_stage.current_stage().Traverse():
        depth = prim.GetPath().pathElementCount
        name = str(prim.GetPath()) if mode == "list" else f"{'  ' * (depth - 1)}{prim.GetName()}"
        lines.append(f"{name} ({prim.GetTypeName()})")
    return "\n".join(lines)


# --- units and time ---
def get_stage_units() -> tuple[float, float]:
    """Return (meters, kilograms) per unit of the stage."""
    stage = used_stage.current_stage()
    return UsdGeom.GetStageMetersPerUnit(stage), UsdPhysics.GetStageKilogramsPerUnit(stage)


def set_stage_units(*, meters_per_unit: float | None = None, kilograms_per_unit: float | None = None) -> None:
    stage = used_stage.current_stage()
    if meters_per_unit is not None:
        UsdGeom.SetStageMetersPerUnit(stage, float(meters_per_unit))
    if kilograms_per_unit is not None:
        UsdPhysics.SetStageKilogramsPerUnit(stage, float(kilograms_per_unit))


def get_stage_up_axis() -> str:
    return older.get_stage_up_axis()


def set_stage_up_axis(up_axis: str) -> None:
    """Set the up axis, "Y" or "Z".

    Raises:
        ValueError: it is another axis.
    """
    if up_axis.upper() not in ("Y", "Z"):
        raise ValueError(f"the up axis is 'Y' or 'Z', not {up_axis!r}")
    older.set_stage_up_axis(up_axis)


def get_stage_time_code() -> tuple[float, float, float]:
    """Return start, end and time codes per second."""
    stage = used_stage.current_stage()
    return stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()


def set_stage_time_code(
    *,
    start_time_code: float | None = None,
    end_time_code: float | None = None,
    time_codes_per_second: float | None = None,
) -> None:
    stage = used_stage.current_stage()
    if start_time_code is not None:
        stage.SetStartTimeCode(start_time_code)
    if end_time_code is not None:
        stage.SetEndTimeCode(end_time_code)
    if time_codes_per_second is not None:
        stage.SetTimeCodesPerSecond(time_codes_per_second)


def _check_path(path: str) -> None:
    if not Sdf.Path.IsValidPathString(path) or not Sdf.Path(path).IsAbsolutePath():
        raise ValueError(f"{path!r} is not the absolute path of a prim")


def _check_name(usd_path: str) -> None:
    if not Usd.Stage.IsSupportedFile(usd_path):
        raise ValueError(f"{usd_path} is not the name of a USD file")
