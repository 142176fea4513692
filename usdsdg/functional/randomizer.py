"""Randomizers that act when the line runs. Mirrors `rep.functional.randomizer`.

`rng` is a ReplicatorRNG or a NumPy Generator, from which the numbers are taken one after the other. Without it a
generator of this module is used, which follows the global seed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from pxr import Gf, Usd, UsdGeom, Vt

from usdsdg.errors import BadPrim, Unsupported
from usdsdg.functional.arguments import prims_of
from usdsdg.rng import ReplicatorRNG, generator_of

__all__ = ["display_color", "provide", "scatter_2d", "scatter_3d"]

_default: ReplicatorRNG | None = None
_provided: dict[str, Callable[..., None]] = {}


def display_color(prims: Any, rng: ReplicatorRNG | np.random.Generator | None = None) -> None:
    """Give each prim a colour of its own (primvars:displayColor), uniform in linear RGB; since 6.0.

    Below a prim that is no shape itself all shapes get the prim's colour.

    Raises:
        BadPrim: there is no shape at or below a prim.
        TypeError: `rng` is neither a ReplicatorRNG nor a NumPy Generator.
    """
    targets = prims_of(prims)
    colors = _generator(rng).uniform(size=(len(targets), 3))
    for prim, color in zip(targets, colors.tolist()):
        shapes = [each for each in Usd.PrimRange(prim) if each.IsA(UsdGeom.Gprim)]
        if not shapes:
            raise BadPrim(f"{prim.GetPath()} has no shape or mesh at or below it that could have a colour")
        for shape in shapes:
            primvar = UsdGeom.Gprim(shape).CreateDisplayColorPrimvar(UsdGeom.Tokens.constant)
            primvar.Set(Vt.Vec3fArray([Gf.Vec3f(*color)]))


def scatter_2d(
    prims: Any, surface_prims: Any, no_collision_prims: Any = None, extents: Any = None, offset: float = 0.0,
    check_for_collisions: bool = False, rng: ReplicatorRNG | np.random.Generator | None = None,
) -> None:  # fmt: skip
    """Place prims at random points of surfaces.

    Args:
        surface_prims: Shapes and meshes (or what holds them) whose surfaces are covered evenly.
        no_collision_prims: Prims that must not be touched.
        extents: Lowest and highest position in the world, ((x, y, z), (x, y, z)) [stage units]; None: open.
        offset: Distance from the surface along its normal [stage units].
        check_for_collisions: Whether the prims must not touch each other, either.
    """
    _scatter("scatter_2d")(
        prims=prims_of(prims), surface_prims=prims_of(surface_prims), no_collision_prims=_prims(no_collision_prims),
        extents=extents, offset=offset, check_for_collisions=check_for_collisions, rng=_generator(rng),
    )  # fmt: skip


def scatter_3d(
    prims: Any, volume_prims: Any = None, no_collision_prims: Any = None, volume_excl_prims: Any = None,
    extents: Any = None, check_for_collisions: bool = False, prevent_vol_overlap: bool = True,
    viz_sampled_voxels: bool = False, resolution_scaling: float = 1.0, input_voxel_size: float = 0.0,
    rng: ReplicatorRNG | np.random.Generator | None = None,
) -> None:  # fmt: skip
    """Place prims at random points of volumes.

    Args:
        volume_prims: Shapes and meshes whose insides are filled evenly; without them `extents` must be complete.
        no_collision_prims: Prims that must not be touched.
        volume_excl_prims: Shapes and meshes whose insides are left out.
        extents: Lowest and highest position in the world, ((x, y, z), (x, y, z)) [stage units].
        check_for_collisions: Whether the prims must not touch each other, either.
        prevent_vol_overlap: Whether a place in several volumes counts once.
        viz_sampled_voxels: Whether the voxels are shown.
        resolution_scaling: Factor on the number of voxels, 30 along the longest side.
        input_voxel_size: Edge of a voxel [stage units]; 0 leaves it to `resolution_scaling`.
    """
    _scatter("scatter_3d")(
        prims=prims_of(prims), volume_prims=_prims(volume_prims), no_collision_prims=_prims(no_collision_prims),
        volume_excl_prims=_prims(volume_excl_prims), extents=extents, check_for_collisions=check_for_collisions,
        prevent_vol_overlap=prevent_vol_overlap, viz_sampled_voxels=viz_sampled_voxels,
        resolution_scaling=resolution_scaling, input_voxel_size=input_voxel_size, rng=_generator(rng),
    )  # fmt: skip


def provide(name: str, scatter: Callable[..., None]) -> None:
    """Let `scatter` do what `scatter_2d` or `scatter_3d` asks for.

    It is called with the keywords of that function: prims as lists of Usd.Prim ([] for None), `rng` as a Generator.
    """
    _provided[name] = scatter


def _scatter(name: str) -> Callable[..., None]:
    if name not in _provided:
        raise Unsupported(f"functional.randomizer.{name} is not available yet; draw positions and use modify.position")
    return _provided[name]


def _prims(value: Any) -> list[Usd.Prim]:
    return [] if value is None else prims_of(value)


def _generator(rng: ReplicatorRNG | np.random.Generator | None) -> np.random.Generator:
    global _default
    if rng is None:
        if _default is None:
            _default = ReplicatorRNG()
        rng = _default
    return generator_of(rng)
