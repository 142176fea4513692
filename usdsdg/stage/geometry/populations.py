"""Populations of drawn assets: where they stand, and point instancers whose instances are objects of their own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Gf, Usd, UsdGeom, Vt

from usdsdg.stage.poses.transforms import as_array, local_to_world, world_to_local
from usdsdg.stage.poses.xform_ops import gf_quat

# Where populations are made.
SAMPLED = "/Replicator/SampledAssets"
# In the custom data of a PointInstancer whose instances are posed and scattered one by one.
POPULATION = "usdsdg:population"


def is_population(prim: Usd.Prim) -> bool:
    """Whether a prim stands for its instances."""
    return prim.IsA(UsdGeom.PointInstancer) and bool(prim.GetCustomDataByKey(POPULATION))


def instance_names(prim: Usd.Prim) -> list[str]:
    """`/path[0]`, `/path[1]`, ...: one name for each instance; it is no prim path."""
    count = len(UsdGeom.PointInstancer(prim).GetProtoIndicesAttr().Get() or ())
    return [f"{prim.GetPath()}[{index}]" for index in range(count)]


def object_names(prims: Sequence[Usd.Prim]) -> list[str]:
    """What is placed when these prims are: themselves, and the instances of populations."""
    return [name for prim in prims for name in (instance_names(prim) if is_population(prim) else [str(prim.GetPath())])]


def world_positions(prim: Usd.Prim) -> np.ndarray:
    """(N, 3) where the instances are in the world [stage units]."""
    positions = np.array(UsdGeom.PointInstancer(prim).GetPositionsAttr().Get() or (), np.float64).reshape(-1, 3)
    to_world = as_array(local_to_world(prim))
    return positions @ to_world[:3, :3] + to_world[3, :3]


def author_world_positions(prim: Usd.Prim, places: np.ndarray) -> None:
    """Place the instances at (N, 3) points of the world.

    Raises:
        DegenerateFrame: the instancer or an ancestor is scaled to nothing.
    """
    to_local = as_array(world_to_local(prim))
    author_positions(prim, places @ to_local[:3, :3] + to_local[3, :3])


def author_positions(prim: Usd.Prim, places: np.ndarray) -> None:
    """Place the instances at (N, 3) points of the instancer's space."""
    points = np.ascontiguousarray(places, np.float32)
    UsdGeom.PointInstancer(prim).CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(points))


def author_orientations(prim: Usd.Prim, quats_xyzw: np.ndarray) -> None:
    """Turn the instances by unit quaternions (N, 4)."""
    turns = Vt.QuathArray([Gf.Quath(gf_quat(quat)) for quat in quats_xyzw])
    UsdGeom.PointInstancer(prim).CreateOrientationsAttr(turns)
