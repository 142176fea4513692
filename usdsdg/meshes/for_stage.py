"""Mesh files that a stage refers to."""

from __future__ import annotations

from pxr import UsdGeom

from usdsdg.meshes.cache import converted
from usdsdg.meshes.conversion import Options
from usdsdg.session.session import current


def converted_for_stage(file: str, label: str | None) -> str:
    """Return the USD file of a mesh file, with the up axis and the units of the current stage.

    Raises:
        AssetUnreadable, Unsupported, OutputNotWritable: it cannot be converted.
    """
    stage = current().stage
    up_axis, unit = (
        ("Z", 1.0) if stage is None else (UsdGeom.GetStageUpAxis(stage), UsdGeom.GetStageMetersPerUnit(stage))
    )
    return converted(file, Options(up_axis=str(up_axis), meters_per_unit=float(unit), label=label))
