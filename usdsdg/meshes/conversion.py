"""From a mesh file to a USD file: read, repair, place, write."""

from __future__ import annotations

import shutil
import uuid
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pxr import Sdf

from usdsdg.errors import AssetUnreadable, ConfigError, OutputNotWritable, Unsupported
from usdsdg.meshes import placement
from usdsdg.meshes.model import MeshFile, Report
from usdsdg.meshes.placement import Origin
from usdsdg.meshes.readers import SUFFIXES, USD, read
from usdsdg.meshes.repairs import repaired
from usdsdg.meshes.usd_file import textures_of, write_usd
from usdsdg.stage.assets.url import check_name, is_utf8

COLLIDERS = ("none", "convexHull", "convexDecomposition", "boundingCube", "boundingSphere", "meshSimplification", "sdf")


@dataclass(frozen=True)
class Options:
    """How a mesh file is converted."""

    up_axis: str = "Z"  # of the USD file
    meters_per_unit: float = 1.0  # of the USD file
    origin: Origin = Origin.KEEP
    source_up_axis: str | None = None  # of the mesh file, where its form does not tell; None: by convention
    source_unit: float | None = None  # meters per unit of the mesh file; None: what it says, or meters
    label: str | None = None  # class; None: no label
    collider: str | None = None  # approximation of UsdPhysics; None: no collider
    names_size: bool = True  # whether an odd size is named; False where its unit is decided later

    def __post_init__(self) -> None:
        if self.up_axis not in ("Y", "Z") or self.source_up_axis not in ("X", "Y", "Z", None):
            raise ConfigError(f"up axis is {self.up_axis!r} from {self.source_up_axis!r}; expected 'Y' or 'Z'")
        if self.collider is not None and self.collider not in COLLIDERS:
            raise ConfigError(f"collider is {self.collider!r}; expected one of {', '.join(COLLIDERS)}")
        for unit in (self.meters_per_unit, self.source_unit):
            if unit is not None and not 0.0 < unit < np.inf:
                raise ConfigError(f"a unit of {unit!r} meters; expected a number above 0")


def convert(source: Path, target: Path, options: Options) -> tuple[Report, MeshFile]:
    """Convert a mesh file to a USD file with its pictures in a folder below `textures/`; nothing is left of a failure.

    Raises:
        AssetUnreadable: the source is damaged or holds no triangles, or its coordinates are too large for a mesh.
        Unsupported: its form, or that of the target, is not known.
        OutputNotWritable: the target cannot be written.
    """
    if target.suffix.lower() not in USD:
        raise Unsupported(f"{target}: a converted mesh is a file {', '.join(USD)}")
    if target.resolve() == source.resolve():
        raise Unsupported(f"{target} is the file itself; give another name for the converted one")
    if source.suffix.lower() not in SUFFIXES:
        raise Unsupported(f"{source} is no mesh file; expected {', '.join(SUFFIXES)}")
    check_name(source)
    _check_target(target)
    mesh, repairs = repaired(_as_meant(read(source), options))
    if not mesh.parts:
        raise AssetUnreadable(f"{source}: no triangle is left after repairs: {'; '.join(repairs)}")
    _check_coordinates(mesh, source, options)
    oddities = placement.oddities(mesh, source.name, origin=options.origin, names_size=options.names_size)
    mesh = placement.placed(
        mesh, up_axis=options.up_axis, meters_per_unit=options.meters_per_unit, origin=options.origin
    )
    _write(mesh, source, target, options)
    notes = [*mesh.notes, *oddities]
    turned = np.abs(mesh.bounds[1] - mesh.bounds[0]) * options.meters_per_unit
    sizes = (float(turned[0]), float(turned[1]), float(turned[2]))
    return Report(sizes, mesh.triangle_count, len(mesh.parts), len(mesh.materials), repairs, notes), mesh


def _check_target(target: Path) -> None:
    """Check that USD can have the path, and name the folder of pictures after it; raises OutputNotWritable if not."""
    if not is_utf8(str(target)) or any(ord(each) < 32 for each in target.stem):
        raise OutputNotWritable(f"{str(target)!r} is no path for USD, which needs one line of UTF-8; give another OUT")


def _check_coordinates(mesh: MeshFile, source: Path, options: Options) -> None:
    """Check that the coordinates are within what a mesh can hold, in the units of the USD file."""
    largest = float(np.abs(mesh.bounds).max())
    scaled = largest * (mesh.meters_per_unit / options.meters_per_unit)
    kind = np.finfo(np.float32)
    if not float(kind.tiny) <= scaled <= float(kind.max):
        raise AssetUnreadable(
            f"{source}: coordinates of up to {largest:.4g} units of {mesh.meters_per_unit:.4g} m are beyond what a "
            f"mesh can hold, {kind.tiny:.1e} to {kind.max:.1e}; give its unit with --unit"
        )


def _as_meant(mesh: MeshFile, options: Options) -> MeshFile:
    up = options.source_up_axis or mesh.up_axis
    return replace(mesh, up_axis=up, meters_per_unit=options.source_unit or mesh.meters_per_unit)


def _write(mesh: MeshFile, source: Path, target: Path, options: Options) -> None:
    """Write beside the target under another name, then move file and pictures into place."""
    work = target.parent / f".{target.stem}-{uuid.uuid4().hex[:8]}"
    try:
        work.mkdir(parents=True)
        collider = None if options.collider == "none" else options.collider
        write_usd(
            mesh, work / target.name, name=source.stem, up_axis=options.up_axis,
            meters_per_unit=options.meters_per_unit, label=options.label, collider=collider,
        )  # fmt: skip
        place = textures_of(target)
        if (work / place).is_dir():
            (target.parent / place).mkdir(parents=True, exist_ok=True)
            for picture in sorted((work / place).iterdir()):
                picture.replace(target.parent / place / picture.name)
        (work / target.name).replace(target)
        if (earlier := Sdf.Layer.Find(str(target))) is not None:
            earlier.Reload(force=True)  # stages of this process still hold the file before
    except OSError as error:
        why = f"{target} cannot be written: {error.strerror or error}"
        failure = OutputNotWritable(f"{why}; give another OUT")
        failure.cause = why
        raise failure from error
    finally:
        shutil.rmtree(work, ignore_errors=True)
