"""Point instancers whose instances are posed and scattered individually."""

from collections.abc import Sequence

import numpy as np
from pxr import Gf, Usd, UsdGeom, Vt

from usdsdg.stage.poses.transforms import as_array, local_to_world, world_to_local
from usdsdg.stage.poses.xform_ops import gf_quat

# Parent of the prims that `randomizer.instantiate` makes.
SAMPLED_ASSETS = "/Replicator/SampledAssets"
# Key in the custom data of a PointInstancer whose instances are posed and scattered individually.
POSABLE_INSTANCES = "usdsdg:population"


def has_posable_instances(prim: Usd.Prim) -> bool:
    """Whether a prim is a PointInstancer whose instances are posed and scattered individually."""
    return prim.IsA(UsdGeom.PointInstancer) and bool(prim.GetCustomDataByKey(POSABLE_INSTANCES))


def instance_names(prim: Usd.Prim) -> list[str]:
    """Return one name for each instance, `/path[0]`, `/path[1]`, ...; they are not prim paths."""
    count = len(UsdGeom.PointInstancer(prim).GetProtoIndicesAttr().Get() or ())
    return [f"{prim.GetPath()}[{index}]" for index in range(count)]


def object_names(prims: Sequence[Usd.Prim]) -> list[str]:
    """Return the paths of prims; for a PointInstancer that `has_posable_instances`, the names of its instances."""
    return [
        name
        for prim in prims
        for name in (instance_names(prim) if has_posable_instances(prim) else [str(prim.GetPath())])
    ]


def world_positions(prim: Usd.Prim) -> np.ndarray:
    """Return the positions (N, 3) of the instances in the world [stage units]."""
    positions = np.array(UsdGeom.PointInstancer(prim).GetPositionsAttr().Get() or (), np.float64).reshape(-1, 3)
    to_world = as_array(local_to_world(prim))
    return positions @ to_world[:3, :3] + to_world[3, :3]


def author_world_positions(prim: Usd.Prim, positions: np.ndarray) -> None:
    """Author the positions (N, 3) of the instances, given in the world [stage units].

    Raises:
        DegenerateFrame: the instancer or an ancestor is scaled to zero.
    """
    to_local = as_array(world_to_local(prim))
    author_positions(prim, positions @ to_local[:3, :3] + to_local[3, :3])


def author_positions(prim: Usd.Prim, positions: np.ndarray) -> None:
    """Author the positions (N, 3) of the instances, given in the instancer's space."""
    points = np.ascontiguousarray(positions, np.float32)
    UsdGeom.PointInstancer(prim).CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(points))


def author_orientations(prim: Usd.Prim, quats_xyzw: np.ndarray) -> None:
    """Author the orientations of the instances: unit quaternions (N, 4) xyzw."""
    orientations = Vt.QuathArray([Gf.Quath(gf_quat(quat)) for quat in quats_xyzw])
    UsdGeom.PointInstancer(prim).CreateOrientationsAttr(orientations)
