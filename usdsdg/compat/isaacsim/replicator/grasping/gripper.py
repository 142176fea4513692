"""A gripper in the simulation: its joints go to their targets and stop where fingers touch something."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from usdsdg.articulations.articulation import Articulation
from usdsdg.articulations.articulations import get_articulations
from usdsdg.session import engines
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.poses.rotations import decompose


def close_around(gripper_path: str, object_path: str) -> Articulation:
    """Let physics steps move a gripper's joints.

    Where physics does not simulate them, those whose links would overlap the object stay; the colliders of links are
    then taken as their boxes.
    """
    gripper = get_articulations().at(gripper_path)
    gripper.stop_before(lambda links: touching(links, object_path))
    return gripper


def touching(links: Collection[str], object_path: str) -> set[str]:
    """Return the links with a collider whose box overlaps a collider at or below the object."""
    engine = engines.physics()
    found = set()
    for link in links:
        for center, half, quat in collider_boxes(current_stage().GetPrimAtPath(link)):
            hits = engine.overlap_box(half.tolist(), center.tolist(), quat.tolist())
            if any(hit.collision == object_path or hit.collision.startswith(object_path + "/") for hit in hits):
                found.add(link)
                break
    return found


def collider_boxes(link: Usd.Prim) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return center, half size [stage units] and rotation xyzw in the world of the box of each enabled collider."""
    cache = UsdGeom.XformCache()
    boxes = []
    for prim in Usd.PrimRange(link, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)):
        enabled = prim.HasAPI(UsdPhysics.CollisionAPI) and UsdPhysics.CollisionAPI(prim).GetCollisionEnabledAttr().Get()
        extent = UsdGeom.Boundable(prim).ComputeExtent(Usd.TimeCode.Default()) if enabled else None
        if not extent:
            continue
        low, high = Gf.Vec3d(extent[0]), Gf.Vec3d(extent[1])
        to_world = cache.GetLocalToWorldTransform(prim)
        pose = decompose(np.array(to_world))
        half = np.abs(np.array((high - low) / 2.0) * pose.scale)
        boxes.append((np.array(to_world.Transform((low + high) / 2.0)), half, pose.rotation))
    return boxes
