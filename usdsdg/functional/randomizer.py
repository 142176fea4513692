"""Immediate randomizers: `rep.functional.randomizer`.

`rng` is a ReplicatorRNG or a NumPy Generator, from which the numbers are drawn in sequence. By default it is the
session's generator, which is seeded with the global seed.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pxr import Gf, Usd, UsdGeom, Vt

from usdsdg.arguments.parameters import name_parameters
from usdsdg.arguments.prims import prims_of
from usdsdg.arguments.values import finite_number, shown
from usdsdg.errors import ArgumentError, BadPrim
from usdsdg.randomizer.scatter import show_voxels
from usdsdg.rng import ReplicatorRNG, generator_of
from usdsdg.scatter import surface, volume
from usdsdg.scatter.bounds import Bounds
from usdsdg.scatter.positions import Draws
from usdsdg.scatter.stage_bodies import scatter, surface_of, volume_of
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage

__all__ = ["display_color", "scatter_2d", "scatter_3d"]


def display_color(prims: Any, rng: ReplicatorRNG | np.random.Generator | None = None) -> None:
    """Set a random color of each prim (primvars:displayColor), uniform in linear RGB; since 6.0.

    For a prim that is not a shape the color is set on all shapes below it.

    Raises:
        BadPrim: there is no shape at or below a prim.
        TypeError: `rng` is neither a ReplicatorRNG nor a NumPy Generator.
    """
    targets = prims_of(prims)
    colors = _generator(rng).uniform(size=(len(targets), 3))
    for prim, color in zip(targets, colors.tolist()):
        shapes = [each for each in Usd.PrimRange(prim) if each.IsA(UsdGeom.Gprim)]
        if not shapes:
            raise BadPrim(f"{prim.GetPath()} has no shape or mesh at or below it that could have a color")
        for shape in shapes:
            primvar = UsdGeom.Gprim(shape).CreateDisplayColorPrimvar(UsdGeom.Tokens.constant)
            primvar.Set(Vt.Vec3fArray([Gf.Vec3f(*color)]))


def scatter_2d(
    prims: Any, surface_prims: Any, no_collision_prims: Any = None, extents: Any = None, offset: float = 0.0,
    check_for_collisions: bool = False, rng: ReplicatorRNG | np.random.Generator | None = None,
) -> None:  # fmt: skip
    """Place the origin of each prim on the surfaces of `surface_prims`, uniformly by area, keeping its rotation.

    Args:
        surface_prims: prims whose meshes (and other shapes, visible or not) are the surface.
        no_collision_prims: obstacles that the prims must not collide with.
        extents: lower and upper bound (x, y, z) of the positions in the world [stage units]; None for no bound.
        offset: distance above the surface along its normal [stage units].
        check_for_collisions: whether the prims must not collide with each other.

    Raises:
        ArgumentError: no surface is given, there is none within the bounds, or a prim has no free position.
    """
    surfaces = prims_of(surface_prims)
    if not surfaces:
        raise ArgumentError(f"scatter_2d: surface_prims is {shown(surface_prims)}; give at least one prim")
    scatter(
        prims_of(prims),
        surface_of(surfaces, _bounds(extents), offset=finite_number("scatter_2d: offset", offset)),
        _draws(rng, surface.COMPONENTS),
        obstacles=_prims(no_collision_prims),
        avoid_each_other=check_for_collisions,
    )


def scatter_3d(
    prims: Any, volume_prims: Any = None, no_collision_prims: Any = None, volume_excl_prims: Any = None,
    extents: Any = None, check_for_collisions: bool = False, prevent_vol_overlap: bool = True,
    viz_sampled_voxels: bool = False, resolution_scaling: float = 1.0, input_voxel_size: float = 0.0,
    rng: ReplicatorRNG | np.random.Generator | None = None,
) -> None:  # fmt: skip
    """Place the origin of each prim inside `volume_prims`, uniformly by volume, keeping its rotation.

    Args:
        volume_prims: closed meshes (or other shapes, visible or not); without any, the box of `extents`.
        no_collision_prims: obstacles that the prims must not collide with.
        volume_excl_prims: closed meshes in which no origin is placed.
        extents: lower and upper bound (x, y, z) of the positions in the world [stage units]; None for no bound.
        check_for_collisions: whether the prims must not collide with each other.
        prevent_vol_overlap: whether the density of positions is the same where volumes overlap.
        viz_sampled_voxels: whether the sampled voxels are shown, under /Replicator/SampledVoxels.
        resolution_scaling: factor on the default of 30 voxels along the longest side of the volumes' mean size.
        input_voxel_size: edge of a voxel [stage units], instead of `resolution_scaling`.

    Raises:
        ArgumentError: there is no volume and a bound is missing, the volume to sample is empty, or a prim has no free
            position.
    """
    if not (resolution_scaling > 0 and input_voxel_size >= 0):
        raise ArgumentError(
            f"scatter_3d: resolution_scaling is {resolution_scaling!r} and input_voxel_size {input_voxel_size!r}; "
            "expected a number above 0, and one of 0 or more"
        )
    region = volume_of(
        _prims(volume_prims),
        _bounds(extents),
        excluded=_prims(volume_excl_prims),
        voxel_size=input_voxel_size,
        resolution_scaling=resolution_scaling,
        prevent_overlap=prevent_vol_overlap,
    )
    drawn = scatter(
        prims_of(prims),
        region,
        _draws(rng, volume.COMPONENTS),
        obstacles=_prims(no_collision_prims),
        avoid_each_other=check_for_collisions,
    )
    if viz_sampled_voxels and isinstance(region, volume.Volume):
        show_voxels(current_stage(), region.voxels(drawn), region.voxel_size)


def _bounds(extents: Any) -> Bounds:
    if extents is None:
        return Bounds.given(None, None)
    if not isinstance(extents, (list, tuple, np.ndarray)) or len(extents) != 2:
        raise ArgumentError(
            f"extents is {shown(extents)}; expected two corners, (x, y, z) lowest and (x, y, z) highest"
        )
    return Bounds.given(extents[0], extents[1])


def _draws(rng: ReplicatorRNG | np.random.Generator | None, components: int) -> Draws:
    generator = _generator(rng)

    def draw(rows: Sequence[int], first: int, tries: int) -> np.ndarray:
        return generator.uniform(size=(len(rows), tries, components))

    return draw


def _prims(value: Any) -> list[Usd.Prim]:
    return [] if value is None else prims_of(value)


def _generator(rng: ReplicatorRNG | np.random.Generator | None) -> np.random.Generator:
    return generator_of(current().default_generator if rng is None else rng)


name_parameters(globals())
