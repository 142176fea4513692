"""Prims of the stage as what scattering needs: bodies around their origins, surfaces and volumes in the world."""

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
    has_posable_instances,
    instance_names,
    object_names,
    world_positions,
)
from usdsdg.stage.geometry.triangles import TriangleInstance, triangles_below
from usdsdg.stage.poses.transforms import parent_to_world
from usdsdg.stage.poses.xform_ops import author_world_position, local_translation


def surface_of(prims: Sequence[Usd.Prim], bounds: Bounds, *, offset: float = 0.0) -> Surface:
    """The surface of all gprims at and below `prims`; see `Surface`.

    Raises:
        ArgumentError: there is none within the bounds.
    """
    return Surface(_corners(triangles_below(prims)), bounds, offset=offset)


def volume_of(
    prims: Sequence[Usd.Prim],
    bounds: Bounds,
    *,
    excluded: Sequence[Usd.Prim] = (),
    voxel_size: float = 0.0,
    resolution_scaling: float = 1.0,
    once: bool = True,
) -> Volume | Box:
    """What closed meshes enclose, one volume per prim; all of the bounds where there are none. See `Volume`, `Box`.

    Raises:
        ArgumentError: a prim has no geometry, or nothing is left to sample.
    """
    taken = [_volume(prim) for prim in excluded]
    if not prims:
        return Box(bounds, taken)
    return Volume(
        [_volume(prim) for prim in prims],
        bounds,
        excluded=taken,
        voxel_size=voxel_size,
        resolution_scaling=resolution_scaling,
        once=once,
    )


def scatter(
    prims: Sequence[Usd.Prim],
    region: Region,
    draw: Draws,
    *,
    avoid: Sequence[Usd.Prim] = (),
    apart: bool = False,
    shapes: dict[bytes, Shape] | None = None,
) -> np.ndarray:
    """Move `prims`, in order, to positions in `region` where they touch none of `avoid`; with `apart` nor each other.

    The instances of a PointInstancer that `has_posable_instances` are moved one by one.

    Args:
        shapes: geometry of earlier calls, which is not prepared again.

    Returns:
        (N, components) the uniform numbers that the positions were drawn from.

    Raises:
        ArgumentError: there is no free position for one of them.
        BadPrim: a prim has no transform.
    """
    bodies: list[Solid] | None = None
    obstacles: list[tuple[Solid, np.ndarray]] = []
    if avoid or apart:
        solids = Solids(shapes)
        bodies = [body for prim in prims for body in _bodies(prim, solids)]
        own = {str(prim.GetPath()) for prim in prims}
        for placed in triangles_below(avoid):
            # A group of obstacles may hold prims that are scattered.
            path = Sdf.Path(placed.path.partition("[")[0])
            if own.isdisjoint(str(prefix) for prefix in path.GetPrefixes()):
                origin = placed.to_world[3, :3]
                obstacles.append((solids.around(origin, [placed]), origin))
    names = object_names(prims)
    positions, chosen = free_positions(names, region, draw, solids=bodies, obstacles=obstacles, apart=apart)
    row = 0
    for prim in prims:
        if has_posable_instances(prim):
            count = len(instance_names(prim))
            author_world_positions(prim, positions[row : row + count])
        else:
            count = 1
            author_world_position(prim, positions[row])
        row += count
    return chosen


def _bodies(prim: Usd.Prim, solids: Solids) -> list[Solid]:
    """The body of a prim, or those of an instancer's instances."""
    placed = triangles_below([prim])
    if not has_posable_instances(prim):
        return [solids.around(_origin(prim), placed)]
    by_name: dict[str, list[TriangleInstance]] = {name: [] for name in instance_names(prim)}
    for each in placed:
        by_name[each.path].append(each)
    return [solids.around(origin, parts) for origin, parts in zip(world_positions(prim), by_name.values())]


def _origin(prim: Usd.Prim) -> np.ndarray:
    """Where in the world the prim's position is: its pivot where it has one."""
    here = Gf.Vec3d(*local_translation(prim).tolist())
    return np.array(parent_to_world(prim).Transform(here))


def _volume(prim: Usd.Prim) -> np.ndarray:
    found = triangles_below([prim])
    if not found:
        raise ArgumentError(f"{prim.GetPath()} has no geometry at or below it, so it encloses no volume")
    return _corners(found)


def _corners(placed: Sequence[TriangleInstance]) -> np.ndarray:
    parts = [each.in_world().corners() for each in placed]
    return np.concatenate(parts) if parts else np.zeros((0, 3, 3))
