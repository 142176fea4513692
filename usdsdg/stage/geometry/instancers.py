"""Point instancers, whose instances are posed and scattered individually."""

from collections.abc import Sequence

import numpy as np
from pxr import Gf, Usd, UsdGeom, Vt

from usdsdg.stage.poses.transforms import as_array, local_to_world, world_to_local
from usdsdg.stage.poses.xform_ops import gf_quat
from usdsdg.stage.scopes import REPLICATOR

# Parent of the prims that `randomizer.instantiate` makes.
SAMPLED_ASSETS = f"{REPLICATOR}/SampledAssets"
# Key in the custom data of the PointInstancer of `randomizer.instantiate`, whose labels are those of each instance.
POPULATION = "usdsdg:population"


def is_instancer(prim: Usd.Prim) -> bool:
    """Whether a prim is a PointInstancer."""
    return prim.IsA(UsdGeom.PointInstancer)


def instance_count(prim: Usd.Prim) -> int:
    """Return how many instances a PointInstancer has: one for each of its protoIndices."""
    return len(UsdGeom.PointInstancer(prim).GetProtoIndicesAttr().Get() or ())


def instance_names(prim: Usd.Prim) -> list[str]:
    """Return one name for each instance, `/path[0]`, `/path[1]`, ...; they are not prim paths."""
    return [f"{prim.GetPath()}[{index}]" for index in range(instance_count(prim))]


def object_names(prims: Sequence[Usd.Prim]) -> list[str]:
    """Return the paths of prims; for a PointInstancer the names of its instances."""
    return [name for prim in prims for name in (instance_names(prim) if is_instancer(prim) else [str(prim.GetPath())])]


def prototypes(prim: Usd.Prim) -> list[Usd.Prim]:
    """Return the prototypes of a PointInstancer that are on the stage, in order, each once."""
    stage, targets = prim.GetStage(), UsdGeom.PointInstancer(prim).GetPrototypesRel().GetForwardedTargets()
    return [found for path in dict.fromkeys(targets) if (found := stage.GetPrimAtPath(path))]


def local_positions(prim: Usd.Prim) -> np.ndarray:
    """Return the positions (N, 3) of the instances in the instancer's space; 0 where it has too few."""
    held = np.array(UsdGeom.PointInstancer(prim).GetPositionsAttr().Get() or (), np.float64).reshape(-1, 3)
    positions = np.zeros((instance_count(prim), 3))
    known = min(len(held), len(positions))
    positions[:known] = held[:known]
    return positions


def local_orientations(prim: Usd.Prim) -> np.ndarray:
    """Return the orientations of the instances, unit quaternions (N, 4) xyzw; no rotation where it has too few."""
    # USD gives quaternions to NumPy as xyzw.
    held = np.array(UsdGeom.PointInstancer(prim).GetOrientationsAttr().Get() or (), np.float64).reshape(-1, 4)
    quats = np.tile([0.0, 0.0, 0.0, 1.0], (instance_count(prim), 1))
    known = min(len(held), len(quats))
    lengths = np.linalg.norm(held[:known], axis=1)
    turned = np.flatnonzero(lengths > 0.0)
    quats[turned] = held[turned] / lengths[turned, None]
    return quats


def world_positions(prim: Usd.Prim) -> np.ndarray:
    """Return the positions (N, 3) of the instances in the world [stage units]."""
    to_world = as_array(local_to_world(prim))
    return local_positions(prim) @ to_world[:3, :3] + to_world[3, :3]


def complete_positions(prim: Usd.Prim) -> None:
    """Give each instance a position, where there are more or fewer: USD computes no transforms then."""
    attribute = UsdGeom.PointInstancer(prim).GetPositionsAttr()
    if len(attribute.Get() or ()) != instance_count(prim):
        author_positions(prim, local_positions(prim))


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


def author_scales(prim: Usd.Prim, scales: np.ndarray) -> None:
    """Author the scales (N, 3) of the instances."""
    factors = np.ascontiguousarray(scales, np.float32)
    UsdGeom.PointInstancer(prim).CreateScalesAttr(Vt.Vec3fArray.FromNumpy(factors))
