"""Drives and states of joints on the stage: degrees of revolute joints, stage units of prismatic ones."""

from __future__ import annotations

import logging

from pxr import Usd, UsdPhysics

from usdsdg.articulations.articulations import get_articulations
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.physics.joints import ARTICULATION_ROOT
from usdsdg.stage.schemas import physx

_log = logging.getLogger("usdsdg.script")


def set_joint_drive_parameters(
    joint_prim: Usd.Prim,
    target_value: float,
    target_type: str = "position",
    stiffness: float | None = None,
    damping: float | None = None,
    max_force: float | None = None,
) -> bool:
    """Set the target of a joint's drive, "position" or "velocity", and what else is given; apply it if missing.

    Returns:
        False, with a warning, where the joint is neither revolute nor prismatic, or the type is another word.
    """
    drive_type = _drive_type(joint_prim)
    if drive_type is None or target_type not in ("position", "velocity"):
        _log.warning("%s: no drive with a target %r", joint_prim.GetPath() if joint_prim else "no joint", target_type)
        return False
    drive = UsdPhysics.DriveAPI.Apply(joint_prim, drive_type)
    create = drive.CreateTargetPositionAttr if target_type == "position" else drive.CreateTargetVelocityAttr
    create().Set(target_value)
    for make, value in (
        (drive.CreateStiffnessAttr, stiffness),
        (drive.CreateDampingAttr, damping),
        (drive.CreateMaxForceAttr, max_force),
    ):
        if value is not None:
            make().Set(value)
    return True


def set_joint_state(joint_prim: Usd.Prim, position_value: float = 0.0, velocity_value: float = 0.0) -> bool:
    """Set the state of a joint, and move the links of its articulation; apply JointStateAPI if missing.

    Returns:
        False, with a warning, where the joint is neither revolute nor prismatic.
    """
    drive_type = _drive_type(joint_prim)
    if drive_type is None:
        _log.warning("%s has no state", joint_prim.GetPath() if joint_prim else "no joint")
        return False
    state = physx.JointStateAPI.Apply(joint_prim, drive_type)  # pyright: ignore[reportAttributeAccessIssue]
    state.CreatePositionAttr().Set(position_value)
    state.CreateVelocityAttr().Set(velocity_value)
    _move_links(joint_prim, position_value, velocity_value)
    return True


def get_joint_state(joint_prim: Usd.Prim) -> tuple[float, float]:
    """Return position and velocity of a joint's JointStateAPI; zeros where it has none."""
    drive_type = _drive_type(joint_prim)
    if drive_type is None:
        return 0.0, 0.0
    names = (f"state:{drive_type}:physics:{name}" for name in ("position", "velocity"))
    attributes = [joint_prim.GetAttribute(name) for name in names]
    position, velocity = (float(each.Get() or 0.0) if each else 0.0 for each in attributes)
    return position, velocity


def apply_joint_pregrasp_state(joint_path: str, position_value: float) -> None:
    """Set the position of the joint at a path, at rest; a path that names no joint is logged."""
    prim = current_stage().GetPrimAtPath(joint_path)
    if not prim or not prim.IsA(UsdPhysics.Joint):
        _log.warning("%s is no joint", joint_path)
        return
    set_joint_state(prim, position_value)


def apply_joint_pregrasp_states(joint_pregrasp_states: dict[str, float]) -> None:
    """Set the positions of joints, by path."""
    for path, position in joint_pregrasp_states.items():
        apply_joint_pregrasp_state(path, position)


def populate_joint_pregrasp_states_from_current(joint_paths: list[str]) -> dict[str, float]:
    """Return the positions of joints by path; 0, with a warning, where a path names no joint."""
    states = {}
    for path in joint_paths:
        prim = current_stage().GetPrimAtPath(path)
        if not prim or not prim.IsA(UsdPhysics.Joint):
            _log.warning("%s is no joint; its position is taken as 0", path)
        states[path] = get_joint_state(prim)[0] if prim else 0.0
    return states


def get_gripper_joints_info(gripper_prim_path: str) -> list[dict]:
    """Return of each joint at or below a prim: path, is_mimic, is_drive, and is_valid_grasp_joint if it is driven."""
    found = []
    for prim in joints_below(gripper_prim_path):
        applied = prim.GetAppliedSchemas()
        is_mimic = any(name.startswith("PhysxMimicJointAPI") for name in applied)
        is_drive = any(name.startswith("PhysicsDriveAPI") for name in applied)
        found.append({
            "path": str(prim.GetPath()),
            "is_mimic": is_mimic,
            "is_drive": is_drive,
            "is_valid_grasp_joint": is_drive and not is_mimic,
        })  # fmt: skip
    return found


def get_gripper_joint_states(gripper_base_path: str) -> dict[str, float] | None:
    """Return the positions of the joints below a prim by their paths relative to it; None if there is no such prim."""
    if not current_stage().GetPrimAtPath(gripper_base_path):
        _log.warning("there is no gripper at %s", gripper_base_path)
        return None
    return {
        str(prim.GetPath()).removeprefix(f"{gripper_base_path}/"): get_joint_state(prim)[0]
        for prim in joints_below(gripper_base_path)
    }


def joints_below(path: str) -> list[Usd.Prim]:
    """Return the joints at or below a path, in the order of the stage."""
    root = current_stage().GetPrimAtPath(path) if path else None
    if not root:
        return []
    prims = Usd.PrimRange(root, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate))
    return [prim for prim in prims if prim.IsA(UsdPhysics.Joint)]


def _drive_type(joint: Usd.Prim) -> str | None:
    if joint and joint.IsA(UsdPhysics.RevoluteJoint):
        return "angular"
    return "linear" if joint and joint.IsA(UsdPhysics.PrismaticJoint) else None


def _move_links(joint: Usd.Prim, position: float, velocity: float) -> None:
    """Move the links of the articulation that the joint belongs to, if there is one."""
    root = joint.GetParent()
    while root and not root.IsPseudoRoot():
        if any(ARTICULATION_ROOT in prim.GetAppliedSchemas() for prim in Usd.PrimRange(root)):
            articulation = get_articulations().at(str(root.GetPath()))
            for row, dof in enumerate(articulation.dofs):
                if dof.path == str(joint.GetPath()):
                    positions, velocities = articulation.positions.copy(), articulation.velocities.copy()
                    positions[row], velocities[row] = position * dof.unit, velocity * dof.unit
                    articulation.set_velocities(velocities)
                    articulation.set_positions(positions)
            return
        root = root.GetParent()
