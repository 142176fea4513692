"""Scattering of prims: reads surfaces, volumes and collision bodies from the stage and writes the positions."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from pxr import Gf, Sdf, Usd

from usdsdg.errors import ArgumentError
from usdsdg.scatter.bounds import Bounds
from usdsdg.scatter.positions import Draws, Region, free_positions
from usdsdg.scatter.solid import Shape, Solid, Solids
from usdsdg.scatter.surface import Surface
from usdsdg.scatter.volume import Box, Volume
from usdsdg.stage.geometry.instancers import (
    author_world_positions,
    complete_positions,
    instance_count,
    instance_names,
    is_instancer,
    object_names,
    world_positions,
)
from usdsdg.stage.geometry.triangles import TriangleInstance, triangles_below
from usdsdg.stage.poses.transforms import parent_to_world
from usdsdg.stage.poses.xform_ops import author_world_position, local_translation


class Places(Protocol):
    """Where prims are: as the stage has them, or in one of many worlds."""

    def triangles(self, prims: Sequence[Usd.Prim]) -> list[TriangleInstance]:
        """Return the triangles at and below prims."""
        ...

    def origin(self, prim: Usd.Prim) -> np.ndarray:
        """Return (3,) the world position of the prim's origin, or of its pivot if it has one."""
        ...


class _OnStage:
    """Where the stage has prims."""

    def triangles(self, prims: Sequence[Usd.Prim]) -> list[TriangleInstance]:
        return triangles_below(prims)

    def origin(self, prim: Usd.Prim) -> np.ndarray:
        in_parent = Gf.Vec3d(*local_translation(prim).tolist())
        return np.array(parent_to_world(prim).Transform(in_parent))


ON_STAGE: Places = _OnStage()


def surface_of(prims: Sequence[Usd.Prim], bounds: Bounds, *, offset: float = 0.0, places: Places = ON_STAGE) -> Surface:
    """Return the surface of all gprims at and below `prims`; see `Surface`.

    Raises:
        ArgumentError: no part of it is within the bounds.
    """
    return Surface(_corners(places.triangles(prims)), bounds, offset=offset)


def volume_of(
    prims: Sequence[Usd.Prim],
    bounds: Bounds,
    *,
    excluded: Sequence[Usd.Prim] = (),
    voxel_size: float = 0.0,
    resolution_scaling: float = 1.0,
    prevent_overlap: bool = True,
    places: Places = ON_STAGE,
) -> Volume | Box:
    """Return the volume that closed meshes enclose, one per prim; without prims the whole box of the bounds.

    See `Volume` and `Box` for the arguments.

    Raises:
        ArgumentError: a prim has no geometry, or the volume to sample is empty.
    """
    excluded_volumes = [_volume(prim, places) for prim in excluded]
    if not prims:
        return Box(bounds, excluded_volumes)
    return Volume(
        [_volume(prim, places) for prim in prims],
        bounds,
        excluded=excluded_volumes,
        voxel_size=voxel_size,
        resolution_scaling=resolution_scaling,
        prevent_overlap=prevent_overlap,
    )


def scatter(
    prims: Sequence[Usd.Prim],
    region: Region,
    draw: Draws,
    *,
    obstacles: Sequence[Usd.Prim] = (),
    avoid_each_other: bool = False,
    shapes: dict[bytes, Shape] | None = None,
) -> np.ndarray:
    """Move `prims`, in order, to sampled positions in `region` where they collide with none of `obstacles`.

    The instances of a PointInstancer are moved individually.

    Args:
        avoid_each_other: whether the prims must not collide with each other.
        shapes: cache of geometry, kept between calls.

    Returns:
        (N, components) the uniform numbers that the positions were computed from.

    Raises:
        ArgumentError: there is no free position for one of them.
        BadPrim: a prim has no transform.
    """
    for prim in filter(is_instancer, prims):
        complete_positions(prim)
    positions, chosen = free_places(
        prims, region, draw, obstacles=obstacles, avoid_each_other=avoid_each_other, shapes=shapes
    )
    row = 0
    for prim in prims:
        if is_instancer(prim):
            count = instance_count(prim)
            author_world_positions(prim, positions[row : row + count])
        else:
            count = 1
            author_world_position(prim, positions[row])
        row += count
    return chosen


def free_places(
    prims: Sequence[Usd.Prim],
    region: Region,
    draw: Draws,
    *,
    obstacles: Sequence[Usd.Prim] = (),
    avoid_each_other: bool = False,
    shapes: dict[bytes, Shape] | None = None,
    places: Places = ON_STAGE,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions (N, 3) that `scatter` moves prims or their instances to, and (N, components) their draws.

    See `scatter` for the arguments.

    Raises:
        ArgumentError: there is no free position for one of them.
    """
    bodies: list[Solid] | None = None
    obstacle_bodies: list[tuple[Solid, np.ndarray]] = []
    if obstacles or avoid_each_other:
        solids = Solids(shapes)
        bodies = [body for prim in prims for body in _bodies(prim, solids, places)]
        own = {str(prim.GetPath()) for prim in prims}
        for placed in places.triangles(obstacles):
            # A group of obstacles may contain prims that are scattered.
            path = Sdf.Path(placed.path.partition("[")[0])
            if own.isdisjoint(str(prefix) for prefix in path.GetPrefixes()):
                origin = placed.to_world[3, :3]
                obstacle_bodies.append((solids.around(origin, [placed]), origin))
    return free_positions(
        object_names(prims), region, draw, solids=bodies, obstacles=obstacle_bodies, avoid_each_other=avoid_each_other
    )


def _bodies(prim: Usd.Prim, solids: Solids, places: Places) -> list[Solid]:
    """Return the collision body of a prim, or those of an instancer's instances."""
    placed = places.triangles([prim])
    if not is_instancer(prim):
        return [solids.around(places.origin(prim), placed)]
    by_name: dict[str, list[TriangleInstance]] = {name: [] for name in instance_names(prim)}
    for each in placed:
        by_name[each.path].append(each)
    return [solids.around(origin, parts) for origin, parts in zip(world_positions(prim), by_name.values())]


def _volume(prim: Usd.Prim, places: Places) -> np.ndarray:
    found = places.triangles([prim])
    if not found:
        raise ArgumentError(f"{prim.GetPath()} has no geometry at or below it, so it encloses no volume")
    return _corners(found)


def _corners(placed: Sequence[TriangleInstance]) -> np.ndarray:
    parts = [each.in_world().corners() for each in placed]
    return np.concatenate(parts) if parts else np.zeros((0, 3, 3))
