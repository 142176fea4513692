"""The joints below a prim as a tree, which turns joint positions into poses of links and back."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdPhysics

from usdsdg.articulations.dynamics import Motion
from usdsdg.errors import BadPrim, warn_once
from usdsdg.stage.physics.joints import WORLD, Joint, articulated_links, is_joint, read_joint
from usdsdg.stage.poses.rotations import compose, decompose
from usdsdg.stage.poses.transforms import as_array, local_to_world
from usdsdg.stage.poses.world_poses import author_world_pose

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Branch:
    """A joint of the tree, from the link that is nearer to the base to the other."""

    joint: Joint
    parent: str
    child: str

    @property
    def is_reversed(self) -> bool:
        """Whether the joint's body 1 is the parent."""
        return self.child == self.joint.body0


class JointTree:
    """The joints below one prim that connect its links to a tree, breadth first from the base.

    The base is the link that a joint attaches to the world, or else one with ArticulationRootAPI, or the first that is
    no joint's body 1. Joints that close loops are left out.
    """

    def __init__(self, stage: Usd.Stage, root: str) -> None:
        """Read the joints at and below the prim at `root`, or those of its bodies where there are none.

        Raises:
            BadPrim: there is no such prim, or no joint that connects two bodies.
        """
        self._stage, self.root = stage, root
        prim = stage.GetPrimAtPath(root)
        joints = _joints_below(prim) if prim else []
        if prim and not any(joint.body0 and joint.body1 for joint in joints):
            # The root may be the base, or the joint that fixes it, with the links beside it.
            links = articulated_links([root], found := _joints_below(stage.GetPseudoRoot()))
            joints = [joint for joint in found if {joint.body0, joint.body1} & links]
        if not any(joint.body0 and joint.body1 for joint in joints):
            raise BadPrim(f"{root} is no articulation: there is no joint between two bodies at or below it")
        self.base = _base(stage, joints)
        self._is_attached = any(
            joint.kind == "Fixed" and {joint.body0, joint.body1} == {WORLD, self.base} for joint in joints
        )
        self.branches = _branches(joints, self.base)
        self.links = [self.base, *(branch.child for branch in self.branches)]
        self.dofs = [branch.joint for branch in self.branches if branch.joint.is_dof]
        others = [
            branch.joint for branch in self.branches if branch.joint.kind not in ("Revolute", "Prismatic", "Fixed")
        ]
        if others:
            warn_once(
                f"{others[0].path}: a joint of this type is held as it is; only revolute and prismatic joints move"
            )
        # What holds joints without a position of their own: the pose of the child seen from the parent.
        poses = self._poses()
        self._held = {
            branch.child: poses[branch.child] @ np.linalg.inv(poses[branch.parent])
            for branch in self.branches
            if not branch.joint.is_dof
        }

    @property
    def is_fixed(self) -> bool:
        """Whether the base stays where it is: a joint fixes it to the world, or it is kinematic."""
        kinematic = UsdPhysics.RigidBodyAPI(self._stage.GetPrimAtPath(self.base)).GetKinematicEnabledAttr()
        return self._is_attached or bool(kinematic and kinematic.Get())

    def motions(self) -> list[Motion]:
        """Return what each joint lets its link do where the links are now on the stage, in the world."""
        row = {link: number for number, link in enumerate(self.links)}
        number = {joint.path: column for column, joint in enumerate(self.dofs)}
        found = []
        for branch in self.branches:
            joint, parent, link = branch.joint, row[branch.parent], row[branch.child]
            if not joint.is_dof:
                found.append(Motion(parent, link))
                continue
            frame = self._frames(joint)[0] @ self._pose(joint.body0)
            axis = -frame[joint.axis, :3] if branch.is_reversed else frame[joint.axis, :3]
            turns = joint.kind == "Revolute"
            found.append(Motion(parent, link, number[joint.path], turns, axis, frame[3, :3]))
        return found

    def positions(self) -> Array:
        """Measure the positions (D,) of the joints on the stage: angles [rad] and distances [stage units]."""
        poses = self._poses()
        found = []
        for branch in self.branches:
            if branch.joint.is_dof:
                frame0, frame1 = self._frames(branch.joint)
                moved = frame1 @ poses[branch.joint.body1] @ np.linalg.inv(frame0 @ poses[branch.joint.body0])
                found.append(_measured(branch.joint, moved))
        return np.array(found, np.float64)

    def place(self, positions: Array) -> None:
        """Author the poses of all links but the base for joint `positions` (D,)."""
        poses = {self.base: self._pose(self.base)}
        number = {joint.path: index for index, joint in enumerate(self.dofs)}
        for branch in self.branches:
            joint = branch.joint
            if not joint.is_dof:
                poses[branch.child] = self._held[branch.child] @ poses[branch.parent]
                continue
            frame0, frame1 = self._frames(joint)
            moved = _moved(joint, float(positions[number[joint.path]]))
            if branch.is_reversed:
                to_parent = np.linalg.inv(frame0) @ np.linalg.inv(moved) @ frame1
            else:
                to_parent = np.linalg.inv(frame1) @ moved @ frame0
            poses[branch.child] = to_parent @ poses[branch.parent]
        # Ancestors first: the pose of a prim is relative to its parent's.
        for link in sorted(self.links[1:], key=lambda path: path.count("/")):
            pose = decompose(poses[link])
            author_world_pose(self._stage.GetPrimAtPath(link), pose.translate, pose.rotation)

    def moved_by(self, joint: Joint) -> set[str]:
        """Return the links that a joint moves: its child and all links after that."""
        moved: set[str] = set()
        for branch in self.branches:
            if branch.joint is joint or branch.parent in moved:
                moved.add(branch.child)
        return moved

    def _poses(self) -> dict[str, Array]:
        return {link: self._pose(link) for link in self.links}

    def _pose(self, link: str) -> Array:
        """Return the row-vector 4x4 of a link's frame in the world, without scale."""
        pose = decompose(as_array(local_to_world(self._stage.GetPrimAtPath(link))))
        return compose(pose.translate, pose.rotation)

    def _frames(self, joint: Joint) -> tuple[Array, Array]:
        """Return both frames of a joint with their translations in stage units."""
        frame0, frame1 = (
            _scaled(frame, self._stage.GetPrimAtPath(body))
            for frame, body in ((joint.frame0, joint.body0), (joint.frame1, joint.body1))
        )
        return frame0, frame1


def _scaled(frame: Array, body: Usd.Prim) -> Array:
    scaled = frame.copy()
    scaled[3, :3] *= decompose(as_array(local_to_world(body))).scale
    return scaled


def _moved(joint: Joint, position: float) -> Array:
    """Return the row-vector 4x4 from frame 1 to frame 0 of a joint."""
    if joint.kind == "Prismatic":
        return compose(position * np.eye(3)[joint.axis])
    return compose(rotation=(*(np.sin(position / 2.0) * np.eye(3)[joint.axis]), np.cos(position / 2.0)))


def _measured(joint: Joint, moved: Array) -> float:
    """Return the position of a joint with frame 1 at `moved` in frame 0."""
    if joint.kind == "Prismatic":
        return float(moved[3, joint.axis])
    j, k = (joint.axis + 1) % 3, (joint.axis + 2) % 3
    return float(np.arctan2(moved[j, k] - moved[k, j], moved[j, j] + moved[k, k]))


def _joints_below(prim: Usd.Prim) -> list[Joint]:
    """Return the joints of articulations at and below a prim."""
    joints = (read_joint(each) for each in Usd.PrimRange(prim) if is_joint(each))
    return [_attached(prim.GetStage(), joint) for joint in joints if joint.in_articulation]


def _attached(stage: Usd.Stage, joint: Joint) -> Joint:
    """Return a joint whose ends that no rigid body carries are attached to the world."""
    ends = [body if body and _is_carried(stage.GetPrimAtPath(body)) else WORLD for body in (joint.body0, joint.body1)]
    return joint if ends == [joint.body0, joint.body1] else replace(joint, body0=ends[0], body1=ends[1])


def _is_carried(prim: Usd.Prim) -> bool:
    """Whether a rigid body is at or above a prim."""
    while prim and not prim.IsPseudoRoot():
        if prim.HasAPI(UsdPhysics.RigidBodyAPI):
            return True
        prim = prim.GetParent()
    return False


def _base(stage: Usd.Stage, joints: list[Joint]) -> str:
    for joint in joints:
        if WORLD in (joint.body0, joint.body1) and (joint.body0 or joint.body1):
            return joint.body0 or joint.body1
    for joint in joints:
        for body in (joint.body0, joint.body1):
            if stage.GetPrimAtPath(body).HasAPI(UsdPhysics.ArticulationRootAPI):
                return body
    children = {joint.body1 for joint in joints}
    return next((joint.body0 for joint in joints if joint.body0 not in children), joints[0].body0)


def _branches(joints: list[Joint], base: str) -> list[Branch]:
    """Return the joints that reach a link first, breadth first."""
    branches, reached, level = [], {base}, [base]
    while level:
        following = []
        for link in level:
            for joint in joints:
                if link not in (joint.body0, joint.body1):
                    continue
                other = joint.body1 if joint.body0 == link else joint.body0
                if other != WORLD and other not in reached:
                    reached.add(other)
                    branches.append(Branch(joint, link, other))
                    following.append(other)
        level = following
    return branches


def drive_of(stage: Usd.Stage, joint: Joint) -> UsdPhysics.DriveAPI:
    """Return the drive of a joint; false if it has none."""
    return UsdPhysics.DriveAPI(stage.GetPrimAtPath(joint.path), joint.drive)
