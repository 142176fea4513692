"""`isaacsim.core.utils.articulations`: roots of articulations on the stage."""

from __future__ import annotations

from functools import reduce

from pxr import Sdf, Usd, UsdPhysics

from usdsdg.articulations.joint_tree import JointTree
from usdsdg.compat.used_stage import current_stage
from usdsdg.errors import BadPrim
from usdsdg.stage.schemas import physx


def add_articulation_root(prim: Usd.Prim) -> None:
    """Make a prim the root of an articulation, with PhysX's attributes."""
    UsdPhysics.ArticulationRootAPI.Apply(prim)
    physx.PhysxArticulationAPI.Apply(prim)


def remove_articulation_root(prim: Usd.Prim) -> None:
    """Let a prim be no root of an articulation."""
    prim.RemoveAPI(UsdPhysics.ArticulationRootAPI)
    prim.RemoveAPI(physx.PhysxArticulationAPI)


def move_articulation_root(src_prim: Usd.Prim, dst_prim: Usd.Prim) -> None:
    """Make another prim the root; does nothing if `src_prim` is none."""
    if src_prim.HasAPI(UsdPhysics.ArticulationRootAPI):
        remove_articulation_root(src_prim)
        add_articulation_root(dst_prim)


def find_all_articulation_base_paths() -> list[str]:
    """Return for each articulation the path of the prim that all of its links are at or below, in the stage's order."""
    stage = current_stage()
    roots = [str(prim.GetPath()) for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.ArticulationRootAPI)]
    return list(dict.fromkeys(_base_path(stage, root) for root in roots))


def _base_path(stage: Usd.Stage, root: str) -> str:
    try:
        links = [Sdf.Path(link) for link in JointTree(stage, root).links]
    except BadPrim:  # one without joints is its root alone
        return root
    return str(reduce(lambda path, link: path.GetCommonPrefix(link), links))
