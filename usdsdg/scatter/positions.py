"""Rejection sampling of one collision-free position per object."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from usdsdg.errors import ArgumentError, let_pass
from usdsdg.scatter.collisions import collide
from usdsdg.scatter.solid import DIRECTIONS, Solid

MAX_TRIES = 10_000
# Triangles of tested pairs of bodies, after which an object counts as not placeable even if there are tries left: some
# seconds for large meshes. It is not a time, so that results do not depend on the machine.
MAX_EFFORT = 100_000_000
# Candidates per batch: the first one is for all objects; batches grow for objects that are hard to place.
_FIRST_BATCH, _GROWTH, _MAX_BATCH = 4, 4, 512


class Region(Protocol):
    """A surface or volume from which candidate positions are sampled."""

    def points(self, u: np.ndarray) -> np.ndarray:
        """Map uniform numbers (..., components) to positions (..., 3); NaN for rejected ones."""
        ...


class Draws(Protocol):
    """Source of uniform random numbers per object and try."""

    def __call__(self, rows: Sequence[int], first: int, tries: int) -> np.ndarray:
        """Return (len(rows), tries, components) numbers for the tries from `first` on of the objects `rows`."""
        ...


class Occupancy:
    """Bodies that already have a position, for collision tests against them."""

    def __init__(self, capacity: int) -> None:
        self._lower = np.empty((capacity, len(DIRECTIONS)))
        self._upper = np.empty_like(self._lower)
        self._bodies: list[tuple[Solid, np.ndarray]] = []
        # Since the last `begin`: positions that were tested, and triangles of the pairs of bodies that were.
        self.tries = self.effort = 0

    def begin(self) -> None:
        """Begin with another object."""
        self.tries = self.effort = 0

    def add(self, solid: Solid, position: np.ndarray) -> None:
        """Add a body at `position` (3,)."""
        row, shift = len(self._bodies), DIRECTIONS @ position
        self._lower[row], self._upper[row] = solid.lower + shift, solid.upper + shift
        self._bodies.append((solid, position))

    def first_free(self, solid: Solid, positions: np.ndarray) -> int | None:
        """Return the index of the first of `positions` (N, 3) where `solid` collides with no body.

        None if there is none, or none before the effort exceeds MAX_EFFORT.
        """
        count = len(self._bodies)
        shift = positions @ DIRECTIONS.T
        lower, upper = solid.lower + shift, solid.upper + shift
        overlap = (self._lower[:count, :3] < upper[:, None, :3]) & (self._upper[:count, :3] > lower[:, None, :3])
        near = np.all(overlap, axis=-1)
        for index in np.flatnonzero(~np.isnan(positions).any(1)):
            self.tries += 1
            rows = np.flatnonzero(near[index])
            slabs = (self._lower[rows, 3:] < upper[index, 3:]) & (self._upper[rows, 3:] > lower[index, 3:])
            if not any(self._collides(solid, positions[index], row) for row in rows[slabs.all(1)]):
                return int(index)
            if self.effort > MAX_EFFORT:
                break
        return None

    def _collides(self, solid: Solid, position: np.ndarray, row: int) -> bool:
        other, other_position = self._bodies[row]
        self.effort += len(solid.corners) + len(other.corners)
        return collide(solid, other, other_position - position)


def free_positions(
    names: Sequence[str], region: Region, draw: Draws, *, solids: Sequence[Solid] | None = None,
    obstacles: Sequence[tuple[Solid, np.ndarray]] = (), avoid_each_other: bool = False,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Choose a position for each object, in order: its first candidate without a collision.

    Args:
        names: prim paths, for messages.
        region: where candidates are sampled.
        draw: uniform numbers per object and try.
        solids: the objects' collision bodies; None if collisions are not checked.
        obstacles: bodies with their positions that the objects must not collide with.
        avoid_each_other: whether the objects must not collide with each other.

    Returns:
        (N, 3) positions and (N, components) the uniform numbers that they were computed from.

    Raises:
        ArgumentError: an object has no free position after MAX_TRIES draws, or after MAX_EFFORT. Where such errors are
            let pass, the object takes the position that was tried last.
    """
    objects = list(range(len(names)))
    u = draw(objects, 0, _FIRST_BATCH)
    candidates = region.points(u)
    positions, chosen = np.empty((len(names), 3)), np.empty((len(names), u.shape[-1]))
    occupied = Occupancy(len(obstacles) + len(names)) if solids is not None else None
    if occupied is not None:
        for solid, position in obstacles:
            occupied.add(solid, position)
    for row in objects:
        numbers, points, tried = u[row], candidates[row], 0
        if occupied is not None:
            occupied.begin()
        while True:
            if occupied is None or solids is None:
                valid = np.flatnonzero(~np.isnan(points).any(1))
                index = int(valid[0]) if len(valid) else None
            else:
                index = occupied.first_free(solids[row], points)
            if index is not None:
                break
            tried += len(points)
            too_much = occupied is not None and occupied.effort > MAX_EFFORT
            if too_much or tried >= MAX_TRIES:
                tries = occupied.tries if occupied is not None and too_much else tried
                have = "has" if row == 1 else "have"
                error = ArgumentError(
                    f"no free position for {names[row]} after {tries:,} tries ({row} of {len(names)} objects {have} "
                    "one)."
                    " Use fewer or smaller objects, or more room."
                )
                on_surface = np.flatnonzero(~np.isnan(points).any(1))
                if not len(on_surface):
                    raise error
                let_pass(error)
                index = int(on_surface[-1])
                break
            numbers = draw([row], tried, min(_MAX_BATCH, len(points) * _GROWTH, MAX_TRIES - tried))[0]
            points = region.points(numbers)
        positions[row], chosen[row] = points[index], numbers[index]
        if occupied is not None and solids is not None and avoid_each_other:
            occupied.add(solids[row], positions[row])
    return positions, chosen
