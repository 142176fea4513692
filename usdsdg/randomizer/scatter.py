"""Random positions on surfaces and in volumes: `rep.randomizer.scatter_2d` and `scatter_3d`."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pxr import Gf, Usd, UsdGeom, Vt

from usdsdg.arguments.prims import prim_at
from usdsdg.arguments.values import finite_number
from usdsdg.errors import ArgumentError
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act
from usdsdg.graph.node import Node, ReplicatorItem, prim_paths
from usdsdg.graph.sampling import get_global_seed, own_seed, uniforms
from usdsdg.scatter import surface, volume
from usdsdg.scatter.bounds import Bounds
from usdsdg.scatter.positions import Draws
from usdsdg.scatter.stage_bodies import ON_STAGE, Places, scatter, surface_of, volume_of
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.geometry.instancers import object_names
from usdsdg.stage.scopes import REPLICATOR, define_scope

# The PointInstancer that shows the voxels for `viz_sampled_voxels`.
VOXELS = f"{REPLICATOR}/SampledVoxels"
Bound = Sequence[float | None]
_OPEN: Bound = (None, None, None)


def scatter_2d(
    surface_prims: Any, no_coll_prims: Any = None, min_samp: Bound = _OPEN, max_samp: Bound = _OPEN,
    seed: int | None = None, offset: float = 0, check_for_collisions: bool = False, input_prims: Any = None,
    name: str | None = None,
) -> ReplicatorItem:  # fmt: skip
    """Place the origin of each prim on the surfaces of `surface_prims`, uniformly by area, keeping its rotation.

    Of a PointInstancer each instance is placed.

    Args:
        surface_prims: prims whose meshes (and other gprims, visible or not) are the surface.
        no_coll_prims: obstacles that the prims must not collide with.
        min_samp: lower bound (x, y, z) of the positions in the world [stage units]; None for no bound.
        max_samp: upper bound.
        seed: replaces the global seed.
        offset: distance above the surface along its normal [stage units].
        check_for_collisions: whether the prims must not collide with each other.

    Bodies collide if their triangles intersect, or if one lies inside the closed surface of another; mere contact is
    no collision. The surface itself is not an obstacle.

    Raises:
        ArgumentError: (a ValueError) no surface is given.
        GraphError: at execution, no surface lies within the bounds, or a prim has no free position after 10,000
            tries, or fewer for large meshes.
    """
    surfaces = _paths_of("scatter_2d", "surface_prims", surface_prims)
    return act(
        "OgnScatter2D", input_prims, name=name, attribute="position", surfacePrims=surfaces,
        noCollPrims=list(prim_paths(no_coll_prims)) or None, offset=finite_number("scatter_2d: offset", offset),
        seed=own_seed(seed), checkForCollisions=bool(check_for_collisions), **_bounds(min_samp, max_samp),
    )  # fmt: skip


@action("OgnScatter2D", "noCollPrims", "seed")
def _scatter_2d(node: Node, execution: int) -> None:
    _scatter(node, surface_in(node), execution, surface.COMPONENTS)


def surface_in(node: Node, places: Places = ON_STAGE) -> surface.Surface:
    """Return the surface that a "OgnScatter2D" node places prims on."""
    inputs = node.inputs
    prims = prims_of(inputs, "surfacePrims")
    return surface_of(prims, _given_bounds(inputs), offset=inputs["offset"], places=places)


def scatter_3d(
    volume_prims: Any = None, no_coll_prims: Any = None, volume_excl_prims: Any = None, min_samp: Bound = _OPEN,
    max_samp: Bound = _OPEN, resolution_scaling: float = 1.0, voxel_size: float = 0.0,
    check_for_collisions: bool = False, prevent_vol_overlap: bool = True, viz_sampled_voxels: bool = False,
    seed: int | None = None, input_prims: Any = None, name: str | None = None,
) -> ReplicatorItem:  # fmt: skip
    """Place the origin of each prim inside `volume_prims`, uniformly by volume, keeping its rotation.

    Of a PointInstancer each instance is placed.

    Args:
        volume_prims: closed meshes (or other gprims, visible or not); without any, the box from `min_samp` to
            `max_samp`.
        no_coll_prims: obstacles that the prims must not collide with.
        volume_excl_prims: closed meshes in which no origin is placed.
        min_samp: lower bound (x, y, z) of the positions in the world [stage units]; None for no bound.
        max_samp: upper bound.
        resolution_scaling: factor on the default of 30 voxels along the longest side of the volumes' mean size.
        voxel_size: edge of a voxel [stage units], instead of `resolution_scaling`. Voxels only approximate the volume
            for sampling: points are inside the meshes whatever the voxel size.
        check_for_collisions: whether the prims must not collide with each other.
        prevent_vol_overlap: whether the density of positions is the same where volumes overlap.
        viz_sampled_voxels: show the sampled voxels, green and translucent, under `/Replicator/SampledVoxels`.
        seed: replaces the global seed.

    Raises:
        ArgumentError: (a ValueError) there is no volume and a bound is missing.
        GraphError: at execution, the volume to sample is empty, or a prim has no free position after 10,000
            tries, or fewer for large meshes.
    """
    volumes, bounds = list(prim_paths(volume_prims)), _bounds(min_samp, max_samp)
    if not volumes:
        volume.Box(_given_bounds(bounds))
    resolution_scaling = finite_number("scatter_3d: resolution_scaling", resolution_scaling)
    voxel_size = finite_number("scatter_3d: voxel_size", voxel_size)
    if not (resolution_scaling > 0 and voxel_size >= 0):
        raise ArgumentError(
            f"randomizer.scatter_3d: resolution_scaling={resolution_scaling!r} must be above 0 and "
            f"voxel_size={voxel_size!r} 0 or more"
        )
    return act(
        "OgnScatter3D", input_prims, name=name, attribute="position", volumePrims=volumes or None,
        noCollPrims=list(prim_paths(no_coll_prims)) or None,
        volumeExclPrims=list(prim_paths(volume_excl_prims)) or None,
        resolutionScaling=resolution_scaling, voxelSize=voxel_size, seed=own_seed(seed),
        checkForCollisions=bool(check_for_collisions), preventVolOverlap=bool(prevent_vol_overlap),
        vizSampledVoxels=bool(viz_sampled_voxels), **bounds,
    )  # fmt: skip


@action("OgnScatter3D", "volumePrims", "noCollPrims", "volumeExclPrims", "seed")
def _scatter_3d(node: Node, execution: int) -> None:
    region = volume_in(node)
    drawn = _scatter(node, region, execution, volume.COMPONENTS)
    if node.inputs["vizSampledVoxels"] and isinstance(region, volume.Volume):
        show_voxels(current_stage(), region.voxels(drawn), region.voxel_size)


def volume_in(node: Node, places: Places = ON_STAGE) -> volume.Volume | volume.Box:
    """Return the volume that a "OgnScatter3D" node places prims in."""
    inputs = node.inputs
    return volume_of(
        prims_of(inputs, "volumePrims"),
        _given_bounds(inputs),
        excluded=prims_of(inputs, "volumeExclPrims"),
        voxel_size=inputs["voxelSize"],
        resolution_scaling=inputs["resolutionScaling"],
        prevent_overlap=inputs["preventVolOverlap"],
        places=places,
    )


def _scatter(
    node: Node, region: surface.Surface | volume.Volume | volume.Box, execution: int, components: int
) -> np.ndarray:
    prims = [prim_at(path) for path in node.prims]
    return scatter(
        prims,
        region,
        draws_of(node, object_names(prims), execution, components),
        obstacles=prims_of(node.inputs, "noCollPrims"),
        avoid_each_other=node.inputs["checkForCollisions"],
        shapes=node.state.setdefault("shapes", {}),
    )


def draws_of(node: Node, names: Sequence[str], execution: int, components: int) -> Draws:
    """Return the source of the uniform numbers of one execution of a scatter node."""
    seed = node.inputs.get("seed", get_global_seed())

    def draw(rows: Sequence[int], first: int, tries: int) -> np.ndarray:
        chosen = [names[row] for row in rows]
        u = uniforms(seed, f"{node.key}/try {first}", execution, chosen, tries * components)
        return u.reshape(len(rows), tries, components)

    return draw


def _paths_of(function: str, argument: str, prims: Any) -> list[str]:
    paths = list(prim_paths(prims))
    if not paths:
        raise ArgumentError(f"randomizer.{function}: {argument} is {prims!r}; give at least one prim")
    return paths


def _bounds(min_samp: Bound, max_samp: Bound) -> dict[str, list[float]]:
    """Return the bounds as node inputs: lists of numbers, infinite where there is no bound."""
    bounds = Bounds.given(min_samp, max_samp)
    return {"minSamp": bounds.lower.tolist(), "maxSamp": bounds.upper.tolist()}


def _given_bounds(inputs: dict[str, Any]) -> Bounds:
    return Bounds.given(inputs["minSamp"], inputs["maxSamp"])


def prims_of(inputs: dict[str, Any], role: str) -> list[Usd.Prim]:
    """Return the prims that an input of a scatter node names."""
    return [prim_at(path) for path in inputs.get(role) or ()]


def show_voxels(stage: Usd.Stage, centers: np.ndarray, size: float) -> UsdGeom.PointInstancer:
    """Show translucent green cubes of edge `size` [stage units] at `centers` (N, 3), replacing earlier ones."""
    define_scope(stage, REPLICATOR)
    instancer = UsdGeom.PointInstancer.Define(stage, VOXELS)
    cube = UsdGeom.Cube.Define(stage, f"{VOXELS}/Voxel")
    cube.CreateSizeAttr(size)
    cube.CreateExtentAttr([Gf.Vec3f(-size / 2), Gf.Vec3f(size / 2)])
    cube.CreateDisplayColorAttr([Gf.Vec3f(0, 1, 0)])
    cube.CreateDisplayOpacityAttr([0.3])
    instancer.CreatePrototypesRel().SetTargets([cube.GetPath()])
    instancer.CreateProtoIndicesAttr(Vt.IntArray(len(centers), 0))
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(centers, np.float32)))
    return instancer
