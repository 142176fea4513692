"""Mesh files, and captured .usdz, that a stage refers to."""

from __future__ import annotations

from pathlib import Path

from pxr import Usd

from usdsdg.errors import warn_once
from usdsdg.meshes.cache import converted
from usdsdg.meshes.conversion import Options
from usdsdg.meshes.readers import usd
from usdsdg.session.session import current
from usdsdg.stage import assets
from usdsdg.stage.poses.transforms import meters_per_unit, up_axis


def converted_for_stage(file: str, label: str | None) -> str:
    """Return the USD file of a mesh file, with the up axis and the units of the current stage.

    A .usdz that has more than meshes, such as a skeleton or physics, stays as it is.

    Raises:
        AssetUnreadable, Unsupported, OutputNotWritable: it cannot be converted.
    """
    stage = current().stage
    up_axis, unit = ("Z", 1.0) if stage is None else _axes(stage)
    if file.lower().endswith(assets.PACKAGE) and not _is_captured(file, up_axis, unit):
        return file
    return converted(file, Options(up_axis=up_axis, meters_per_unit=unit, label=label))


def _is_captured(file: str, up_axis: str, unit: float) -> bool:
    package = Usd.Stage.Open(assets.open_layer(file))
    more = usd.left_out(package)
    if more and _axes(package) != (up_axis, unit):
        own_up, own_unit = _axes(package)
        warn_once(
            f"{file} has {' and '.join(more)}, so it is not converted to the axes and units of the stage: it has "
            f"{own_up} up and {own_unit:g} m per unit, the stage {up_axis} up and {unit:g} m. Rotate and scale it, or "
            f"convert its meshes alone with usdsdg convert {Path(file).name} OUT.usd"
        )
    return not more


def _axes(stage: Usd.Stage) -> tuple[str, float]:
    return up_axis(stage), meters_per_unit(stage)
