"""Placing a mesh on a stage: its up axis, its units, its origin, and sizes that look like mistakes."""

from __future__ import annotations

import enum

import numpy as np

from usdsdg.errors import ConfigError
from usdsdg.meshes.model import MeshFile

# Sizes of single objects beyond these are named [m].
SMALLEST, LARGEST, TYPICAL = 0.002, 50.0, 0.3
# Sizes that objects on a table or in a bin have [m]; meshes of other sizes are in another unit.
PLAUSIBLE = (0.002, 3.0)
# Distance from its origin at which an object turns about a point far outside, in its own size.
FAR = 2.0
MANY_TRIANGLES = 1_000_000

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254, "foot": 0.3048}
# The likeliest first: that of CAD comes before others.
_LIKELY = ("m", "mm", "cm", "inch", "foot")


def meters_of(unit: str) -> float:
    """Return the meters of a unit, by its name or as a number.

    Raises:
        ConfigError: it is neither.
    """
    try:
        return UNITS[unit] if unit in UNITS else float(unit)
    except ValueError:
        raise ConfigError(f"unit is {unit!r}; expected one of {', '.join(UNITS)}, or a number of meters") from None


class Origin(enum.Enum):
    """Where the origin of the converted asset is."""

    KEEP = "keep"  # that of the file
    CENTER = "center"  # of its bounds
    BOTTOM = "bottom"  # the center of the bottom of its bounds


def placed(mesh: MeshFile, *, up_axis: str, meters_per_unit: float, origin: Origin) -> MeshFile:
    """Return the mesh with another up axis, in units of a stage, with its origin where it is wanted."""
    turned = mesh.moved(axes(mesh.up_axis, up_axis, mesh.meters_per_unit / meters_per_unit))
    if origin is Origin.KEEP:
        return turned
    low, high = turned.bounds
    center = (low + high) / 2.0
    if origin is Origin.BOTTOM:
        center["XYZ".index(up_axis)] = low["XYZ".index(up_axis)]
    matrix = np.eye(4)
    matrix[3, :3] = -center
    return turned.moved(matrix)


def axes(source: str, target: str, scale: float) -> np.ndarray:
    """Return the row-vector matrix (4, 4) from one up axis to another, with a factor for units.

    From Y to Z the object is turned by 90 degrees about X, so that what looked along +Z in the file looks along -Y, as
    USD's own tools do.
    """
    to_z = {
        "Z": np.eye(3),
        "Y": np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]),  # x -> x, y -> z, z -> -y
        "X": np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]),  # x -> z, y -> y, z -> -x
    }
    matrix = np.eye(4)
    matrix[:3, :3] = to_z[source] @ to_z[target].T * scale
    return matrix


def oddities(mesh: MeshFile, name: str, *, origin: Origin, names_size: bool = True) -> list[str]:
    """Return what looks like a mistake in the size or the place of an object, or is a lot, each with its remedy."""
    low, high = mesh.bounds
    found = [size_problem(float((high - low).max()), mesh.meters_per_unit, name)] if names_size else []
    if origin is Origin.KEEP:
        away = float(np.linalg.norm(np.maximum(np.maximum(low, -high), 0.0)))
        if away > FAR * float((high - low).max()):
            found.append(
                f"{name} is {away * mesh.meters_per_unit:.4g} m away from its origin, about which it is posed; convert "
                "it with --origin bottom or center"
            )
    if mesh.triangle_count > MANY_TRIANGLES:
        found.append(f"{name} has {mesh.triangle_count:,} triangles; reduce them where memory or physics needs it")
    return [each for each in found if each]


def likely_unit(extent: float) -> str:
    """Return the likeliest unit of an object's largest extent: the first that makes it plausible, else the nearest."""
    fitting = (unit for unit in _LIKELY if is_plausible(extent * UNITS[unit]))
    return next(fitting, min(_LIKELY, key=lambda unit: abs(np.log(extent * UNITS[unit] / TYPICAL))))


def is_plausible(meters: float) -> bool:
    """Return whether an object on a table or in a bin may have this size."""
    return PLAUSIBLE[0] <= meters <= PLAUSIBLE[1]


def size_problem(extent: float, meters_per_unit: float, name: str) -> str:
    """Return what is odd about the largest extent of an object, in the units of its file, with the remedy; or ""."""
    largest = extent * meters_per_unit
    if SMALLEST <= largest <= LARGEST:
        return ""
    likely = likely_unit(extent)
    if SMALLEST <= extent * UNITS[likely] <= LARGEST:
        remedy = f"if it is in {likely}, convert it with --unit {likely}"
    else:
        factor = 10.0 ** round(float(np.log10(TYPICAL / extent)))
        remedy = f"a factor of {factor / meters_per_unit:g} is missing; convert it with --unit {factor:g}"
    return f"{name} is {largest:.4g} m large, which is odd for an object; {remedy}"
