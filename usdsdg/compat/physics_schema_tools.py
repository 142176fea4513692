"""`pxr.PhysicsSchemaTools`: paths as integers, which hits of scene queries hold, and a ground plane.

usd-core does not have this module; `install` adds it to `pxr`.
"""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Sdf, Usd

from usdsdg.errors import BadValue
from usdsdg.session.session import current
from usdsdg.stage.physics.ground_plane import add_ground_plane

__all__ = ["addGroundPlane", "decodeSdfPath", "encodeSdfPath", "intToSdfPath", "sdfPathToInt"]

_HALF = 32


class PathIds:
    """The integers of paths, counted up in the order of their first use; 0 is the empty path."""

    def __init__(self) -> None:
        self._paths = [Sdf.Path()]
        self._ids = {Sdf.Path(): 0}

    def of(self, path: Sdf.Path) -> int:
        """Return the integer of a path, a new one at its first use."""
        if path not in self._ids:
            self._ids[path] = len(self._paths)
            self._paths.append(path)
        return self._ids[path]

    def path(self, identifier: int) -> Sdf.Path:
        """Return the path of an integer from `of`.

        Raises:
            BadValue: it is not one.
        """
        if not 0 <= identifier < len(self._paths):
            raise BadValue(f"{identifier} is not the integer of a path; take one from sdfPathToInt or a query's hit")
        return self._paths[identifier]


def sdfPathToInt(path: Sdf.Path | str) -> int:
    """Return an integer for a path, 0 for an empty one; `intToSdfPath` gives the path back in the same process."""
    # USD prints a warning of a path that is made of an empty string.
    return current().path_ids.of(Sdf.Path(str(path)) if str(path) else Sdf.Path())


def intToSdfPath(intPath: int) -> Sdf.Path:
    """Return the path of an integer.

    Raises:
        BadValue: it is not from `sdfPathToInt` or a hit of a scene query.
    """
    return current().path_ids.path(int(intPath))


def encodeSdfPath(path: Sdf.Path | str) -> tuple[int, int]:
    """Return a path's integer as two of 32 bits, the lower one first."""
    identifier = sdfPathToInt(path)
    return identifier & ((1 << _HALF) - 1), identifier >> _HALF


def decodeSdfPath(part0: int, part1: int) -> Sdf.Path:
    """Return the path of two integers from `encodeSdfPath`.

    Raises:
        BadValue: they are not.
    """
    return intToSdfPath(int(part0) + (int(part1) << _HALF))


def addGroundPlane(
    stage: Usd.Stage,
    planePath: str,
    axis: str,
    size: float,
    position: Sequence[float],
    color: Sequence[float],
) -> str:
    """Define a ground plane below `planePath`: a square mesh that is seen, and an unbounded plane that collides.

    Args:
        axis: Normal of the plane: "X", "Y" or "Z".
        size: Half of the length of the square's edges [stage units].
        position: Of its center [stage units].
        color: RGB from 0 to 1.

    Returns:
        The path of the plane.
    """
    place = (float(position[0]), float(position[1]), float(position[2]))
    seen = (float(color[0]), float(color[1]), float(color[2]))
    add_ground_plane(stage, planePath, axis=axis.upper(), half_size=float(size), position=place, color=seen)
    return planePath
