"""Placing a mesh on a stage: its up axis, its units, its origin, and sizes that look like mistakes."""

from __future__ import annotations

import enum

import numpy as np

from usdsdg.meshes.model import MeshFile

# Sizes of single objects beyond these are named [m].
SMALLEST, LARGEST, TYPICAL = 0.002, 50.0, 0.3

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254, "foot": 0.3048}


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


def size_problem(size: np.ndarray, name: str) -> str:
    """Return what is odd about the size [m] of an object, with the remedy; "" if nothing is."""
    largest = float(np.max(size))
    if SMALLEST <= largest <= LARGEST:
        return ""
    likely = min(UNITS, key=lambda unit: abs(np.log(largest * UNITS[unit] / TYPICAL)))
    hint = f"; if it is in {likely}, convert it with --unit {likely}" if likely != "m" else ""
    return f"{name} is {largest:.4g} m large, which is odd for an object{hint}"
