"""Scattering of prims: reads surfaces, volumes and collision bodies from the stage and writes the positions."""

from collections.abc import Sequence

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


def surface_of(prims: Sequence[Usd.Prim], bounds: Bounds, *, offset: float = 0.0) -> Surface:
    """Return the surface of all gprims at and below `prims`; see `Surface`.

    Raises:
        ArgumentError: no part of it is within the bounds.
    """
    return Surface(_corners(triangles_below(prims)), bounds, offset=offset)


def volume_of(
    prims: Sequence[Usd.Prim],
    bounds: Bounds,
    *,
    excluded: Sequence[Usd.Prim] = (),
    voxel_size: float = 0.0,
    resolution_scaling: float = 1.0,
    prevent_overlap: bool = True,
) -> Volume | Box:
    """Return the volume that closed meshes enclose, one per prim; without prims the whole box of the bounds.

    See `Volume` and `Box` for the arguments.

    Raises:
        ArgumentError: a prim has no geometry, or the volume to sample is empty.
    """
    excluded_volumes = [_volume(prim) for prim in excluded]
    if not prims:
        return Box(bounds, excluded_volumes)
    return Volume(
        [_volume(prim) for prim in prims],
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
    bodies: list[Solid] | None = None
    obstacle_bodies: list[tuple[Solid, np.ndarray]] = []
    for prim in filter(is_instancer, prims):
        complete_positions(prim)
    if obstacles or avoid_each_other:
        solids = Solids(shapes)
        bodies = [body for prim in prims for body in _bodies(prim, solids)]
        own = {str(prim.GetPath()) for prim in prims}
        for placed in triangles_below(obstacles):
            # A group of obstacles may contain prims that are scattered.
            path = Sdf.Path(placed.path.partition("[")[0])
            if own.isdisjoint(str(prefix) for prefix in path.GetPrefixes()):
                origin = placed.to_world[3, :3]
                obstacle_bodies.append((solids.around(origin, [placed]), origin))
    names = object_names(prims)
    positions, chosen = free_positions(
        names, region, draw, solids=bodies, obstacles=obstacle_bodies, avoid_each_other=avoid_each_other
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


def _bodies(prim: Usd.Prim, solids: Solids) -> list[Solid]:
    """Return the collision body of a prim, or those of an instancer's instances."""
    placed = triangles_below([prim])
    if not is_instancer(prim):
        return [solids.around(_origin(prim), placed)]
    by_name: dict[str, list[TriangleInstance]] = {name: [] for name in instance_names(prim)}
    for each in placed:
        by_name[each.path].append(each)
    return [solids.around(origin, parts) for origin, parts in zip(world_positions(prim), by_name.values())]


def _origin(prim: Usd.Prim) -> np.ndarray:
    """Return the world position of the prim's origin, or of its pivot if it has one."""
    in_parent = Gf.Vec3d(*local_translation(prim).tolist())
    return np.array(parent_to_world(prim).Transform(in_parent))


def _volume(prim: Usd.Prim) -> np.ndarray:
    found = triangles_below([prim])
    if not found:
        raise ArgumentError(f"{prim.GetPath()} has no geometry at or below it, so it encloses no volume")
    return _corners(found)


def _corners(placed: Sequence[TriangleInstance]) -> np.ndarray:
    parts = [each.in_world().corners() for each in placed]
    return np.concatenate(parts) if parts else np.zeros((0, 3, 3))
