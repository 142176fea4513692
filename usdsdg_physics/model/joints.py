"""Add the joints of a scene to a Newton model: a tree for each group of bodies, and what closes loops."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.errors import warn_once
from usdsdg.stage.poses.rotations import matrix_from_quat
from usdsdg_physics.model.chain_armature import add_chain_armature
from usdsdg_physics.scene.joint_trees import Branch, JointTree, joint_trees
from usdsdg_physics.scene.records import STATIC, Axis, Drive, Joint, Scene, Vec3

if TYPE_CHECKING:
    import newton

# Newton's rows for limits and drives of an axis, and for the contacts of a link.
RUBBING = 1e6  # N s/m or N m s/rad, of what stands for friction
ROWS_PER_AXIS = 4
ROWS_PER_LINK = 48
ROWS_PER_LOOP = 6
MIN_ROWS = 256
# Part of the inertia that three axes of rotation move which each of them has of its own. Where the angle of the middle
# one reaches 90 degrees, the others coincide: without any they turn against each other without bound.
REGULAR_SHARE = 0.03


@dataclass(frozen=True)
class JointAxis:
    """An axis of a joint of the scene and its place in Newton's arrays."""

    joint: str  # path
    axis: Axis
    coordinate: int  # in joint_q
    dof: int  # in joint_qd and the arrays of drives and limits


@dataclass
class BuiltJoints:
    """The joints of a model; indices are those of Newton's arrays."""

    trees: list[JointTree] = field(default_factory=list)
    articulations: list[int] = field(default_factory=list)  # by tree
    # By tree: begin and end of its coordinates in joint_q, and in joint_qd.
    ranges: list[tuple[int, int, int, int]] = field(default_factory=list)
    axes: list[JointAxis] = field(default_factory=list)
    joint_of: dict[str, int] = field(default_factory=dict)  # Newton's joint by path
    links: dict[str, int] = field(default_factory=dict)  # by body: the tree that it belongs to
    bases: dict[str, tuple[int, int]] = field(default_factory=dict)  # by body: where it is in joint_q and joint_qd
    # By body that is the base of an articulation: Newton's joint that fixes it to the world.
    fixed_bases: dict[str, int] = field(default_factory=dict)
    # Of joints that follow others from where both are: path of the joint and of the one that it follows, and gearing.
    in_gear: list[tuple[str, str, float]] = field(default_factory=list)

    @property
    def breakable(self) -> list[tuple[str, int, float, float]]:
        """Path, number, force and torque of the joints that break."""
        joints = [branch.joint for tree in self.trees for branch in tree.branches]
        return [
            (joint.path, self.joint_of[joint.path], joint.break_force, joint.break_torque)
            for joint in joints
            if joint.breaks
        ]

    @property
    def rubbing(self) -> list[tuple[int, int, float, float]]:
        """Joint, number in joint_qd, friction and friction per load of the axes with friction, and without a drive."""
        return [
            (self.joint_of[row.joint], row.dof, row.axis.static_friction, row.axis.friction)
            for row in self.axes
            if row.axis.drive is None and (row.axis.static_friction or row.axis.friction)
        ]

    @property
    def rows(self) -> int:
        """Rows of the solver that limits, drives, loops and contacts of links may need."""
        loops = sum(len(tree.loops) for tree in self.trees)
        links = sum(len(tree.bodies) for tree in self.trees)
        return max(MIN_ROWS, ROWS_PER_AXIS * len(self.axes) + ROWS_PER_LOOP * loops + ROWS_PER_LINK * links)


def scene_trees(scene: Scene) -> list[JointTree]:
    """Return the trees of the joints of a scene."""
    return joint_trees(scene.bodies, scene.joints.values()) if scene.joints else []


def add_joints(
    builder: newton.ModelBuilder, trees: Sequence[JointTree], scene: Scene, body_index: Mapping[str, int]
) -> BuiltJoints:
    """Add trees of joints between bodies that are links of the builder."""
    import newton

    built = BuiltJoints(list(trees))
    for number, tree in enumerate(trees):
        added, first_q, first_qd = [], builder.joint_coord_count, builder.joint_dof_count
        if tree.root:
            built.bases[tree.root] = builder.joint_coord_count, builder.joint_dof_count
            added.append(builder.add_joint_free(body_index[tree.root], label=f"{tree.root} base"))
        for branch in tree.branches:
            added.append(_add_branch(builder, branch, scene, body_index, built))
        add_chain_armature(builder, tree, scene, body_index, built.joint_of)
        built.ranges.append((first_q, builder.joint_coord_count, first_qd, builder.joint_dof_count))
        built.articulations.append(builder.articulation_count)
        builder.add_articulation(added, label=tree.root or tree.branches[0].joint.path)
        built.links |= dict.fromkeys(tree.bodies, number)
    for tree in trees:
        for branch in tree.loops:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", newton.NewtonWarning)  # that both connect the same bodies
                _add_loop(builder, branch, body_index, built)
        _add_mimics(builder, tree, built)
    return built


def _add_branch(
    builder: newton.ModelBuilder, branch: Branch, scene: Scene, body_index: Mapping[str, int], built: BuiltJoints
) -> int:
    joint = branch.joint
    start_q, start_qd = builder.joint_coord_count, builder.joint_dof_count
    parent, child, frames = _ends(branch, body_index)
    if joint.kind == "fixed" and parent < 0 and joint.articulated:
        # As in PhysX, the fixed base of an articulation stays where the body is.
        frames["parent_xform"] = _base_frame(scene.bodies[branch.child].pose, _frame(branch, child=True))
    axes = joint.axes
    if branch.is_reversed:
        # From body 1 the same motion is the inverse: rotations in the opposite order around opposite directions.
        axes = (*(a for a in axes if not a.angular), *reversed([a for a in axes if a.angular]))
        if 0 < sum(axis.angular for axis in axes) < len(axes):
            warn_once(
                f"{joint.path}: seen from its body 1, which is nearer to the base, distances are measured in the frame "
                "of body 1. Exchange physics:body0 and physics:body1 if it both turns and slides."
            )
    configs = [_config(axis, flipped=branch.is_reversed) for axis in axes]
    if joint.kind == "fixed":
        index = builder.add_joint_fixed(parent, child, **frames)
    elif joint.kind == "ball":
        index = builder.add_joint_ball(parent, child, **frames)
    elif joint.kind == "revolute":
        index = builder.add_joint_revolute(parent, child, axis=configs[0], **frames)
    elif joint.kind == "prismatic":
        index = builder.add_joint_prismatic(parent, child, axis=configs[0], **frames)
    else:
        linear = [config for config, axis in zip(configs, axes) if not axis.angular]
        angular = [config for config, axis in zip(configs, axes) if axis.angular]
        if len(angular) == 3:
            _keep_regular(angular, _moved_inertia(builder, child, _frame(branch, child=True)))
        index = builder.add_joint_d6(parent, child, linear_axes=linear, angular_axes=angular, **frames)
    built.joint_of[joint.path] = index
    if joint.kind == "fixed" and parent < 0 and joint.articulated:
        built.fixed_bases[branch.child] = index
    if any(axis.drive and (axis.static_friction or axis.friction) for axis in axes):
        warn_once(f"{joint.path}: a joint with a drive has no dry friction. Use the damping of its drive.")
    for number, axis in enumerate(axes):
        built.axes.append(JointAxis(joint.path, axis, start_q + number, start_qd + number))
    return index


def _add_loop(builder: newton.ModelBuilder, branch: Branch, body_index: Mapping[str, int], built: BuiltJoints) -> None:
    import warp as wp

    joint = branch.joint
    parent, child, frames = _ends(branch, body_index)
    if joint.kind == "weld":
        # At the center of mass forces and torques do not depend on each other.
        frames["parent_xform"] = frames["child_xform"] = wp.transform(builder.body_com[child], wp.quat_identity())
    if joint.kind == "revolute":
        index = builder.add_joint_revolute(parent, child, axis=joint.axes[0].direction, **frames)
    elif joint.kind in ("fixed", "weld"):
        index = builder.add_joint_fixed(parent, child, **frames)
    else:
        index = builder.add_joint_ball(parent, child, **frames)
    built.joint_of[joint.path] = index


def _add_mimics(builder: newton.ModelBuilder, tree: JointTree, built: BuiltJoints) -> None:
    joints = {branch.joint.path: branch.joint for branch in tree.branches}
    for joint in joints.values():
        if joint.mimic is None:
            continue
        leader, gearing, offset = _leader(joint, joints)
        if leader is None or len(joint.axes) != 1 or len(leader.axes) != 1 or leader is joint:
            warn_once(
                f"{joint.path} cannot follow {joint.mimic.leader}, so it moves freely: both need one axis, and joints "
                "that connect their bodies, loops not counted."
            )
            continue
        if offset is None:
            built.in_gear.append((joint.path, leader.path, gearing))
        builder.set_joint_mimic(
            built.joint_of[joint.path], built.joint_of[leader.path], coeffs=(offset or 0.0, gearing)
        )


def _leader(joint: Joint, joints: Mapping[str, Joint]) -> tuple[Joint | None, float, float | None]:
    """Return the joint at the end of a chain of followers, with gearing and offset to it; None where there is none."""
    gearing, offset, seen = 1.0, 0.0, {joint.path}
    leader: Joint | None = joint
    while leader is not None and leader.mimic is not None:
        own = leader.mimic.offset
        offset = None if offset is None or own is None else offset + gearing * own
        gearing = gearing * leader.mimic.gearing
        leader = joints.get(leader.mimic.leader)
        if leader is None or leader.path in seen:
            return None, gearing, offset
        seen.add(leader.path)
    return leader, gearing, offset


def _ends(branch: Branch, body_index: Mapping[str, int]) -> tuple[int, int, dict]:
    import warp as wp

    parent = body_index[branch.parent] if branch.parent != STATIC else -1
    frames = {
        "parent_xform": wp.transform(*_frame(branch, child=False)),
        "child_xform": wp.transform(*_frame(branch, child=True)),
        # Pairs that do not collide are those of the scene.
        "collision_filter_parent": False,
        "label": branch.joint.path,
    }
    return parent, body_index[branch.child], frames


def _frame(branch: Branch, *, child: bool) -> tuple[float, ...]:
    return branch.joint.frame0 if child == branch.is_reversed else branch.joint.frame1


def _base_frame(pose: Sequence[float], frame: Sequence[float]) -> object:
    import warp as wp

    return wp.transform(*pose) * wp.transform(*frame)


def _config(axis: Axis, *, flipped: bool) -> newton.ModelBuilder.JointDofConfig:
    import newton

    drive = axis.drive or _friction_drive(axis)
    config = newton.ModelBuilder.JointDofConfig(
        axis=_flipped(axis.direction) if flipped else axis.direction,
        limit_lower=axis.lower,
        limit_upper=axis.upper,
        target_ke=drive.stiffness if drive else 0.0,
        target_kd=drive.damping if drive else 0.0,
        damping=axis.damping,
        armature=axis.armature,
        effort_limit=drive.max_force if drive else float("inf"),
        velocity_limit=axis.max_velocity,
    )
    # Not by the constructor, which replaces targets outside of the limits.
    config.target_q = drive.target if drive else 0.0
    config.target_qd = drive.target_velocity if drive else 0.0
    return config


def _keep_regular(angular: Sequence[newton.ModelBuilder.JointDofConfig], inertia: float) -> None:
    """Give three axes of rotation a little inertia of their own, for angles at which two of them coincide."""
    for config in angular:
        config.armature = max(config.armature, REGULAR_SHARE * inertia)


def _moved_inertia(builder: newton.ModelBuilder, body: int, frame: Sequence[float]) -> float:
    """Return the mean moment of inertia [kg m²] of a body about the origin of a joint."""
    arm = np.asarray(frame[:3]) - np.asarray(builder.body_com[body])
    moments = np.asarray(builder.body_inertia[body], np.float64).reshape(3, 3)
    return float(np.trace(moments) / 3.0 + 2.0 / 3.0 * builder.body_mass[body] * (arm @ arm))


def _friction_drive(axis: Axis) -> Drive | None:
    """Return the drive to no velocity whose strength is an axis's friction, for one without a drive."""
    if not (axis.static_friction or axis.friction):
        return None
    return Drive(0.0, RUBBING, 0.0, 0.0, max(axis.static_friction, 1e-9))


def _flipped(direction: Vec3) -> Vec3:
    x, y, z = direction
    return -x, -y, -z


def measured_drift(tree: JointTree, poses: Mapping[str, Sequence[float]]) -> tuple[str, float]:
    """Return the joint whose frames are farthest apart where its axes cannot move them, and how far [m]."""
    worst, distance = "", 0.0
    for branch in tree.branches:
        joint = branch.joint
        stays = joint.articulated and joint.kind == "fixed" and STATIC in (joint.body0, joint.body1)
        if stays or any(not axis.angular for axis in joint.axes):
            continue
        ends = [
            _placed(poses.get(body), frame)
            for body, frame in ((joint.body0, joint.frame0), (joint.body1, joint.frame1))
        ]
        apart = float(np.linalg.norm(ends[0] - ends[1]))
        if apart > distance:
            worst, distance = joint.path, apart
    return worst, distance


def _placed(pose: Sequence[float] | None, frame: Sequence[float]) -> np.ndarray:
    if pose is None:
        return np.asarray(frame[:3])
    return np.asarray(frame[:3]) @ matrix_from_quat(np.asarray(pose[3:])) + np.asarray(pose[:3])
