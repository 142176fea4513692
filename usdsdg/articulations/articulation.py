"""An articulation in motion: joint positions and velocities, drives and limits."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pxr import Usd

from usdsdg.articulations.joint_tree import JointTree, drive_of
from usdsdg.errors import PhysicsError
from usdsdg.session import engines
from usdsdg.stage.physics.joints import Joint

Array = NDArray[np.float64]

# Followed by the name of the instance, such as rotX.
_MIMIC = "PhysxMimicJointAPI:"
# A joint that would touch something stops within this power of one half of its step before it.
_HALVINGS = 4


@dataclass(frozen=True)
class Drive:
    """A drive in the units of positions: rad or stage units."""

    stiffness: float
    damping: float
    target: float
    target_velocity: float
    max_force: float = np.inf  # torque, or force of a prismatic joint, in stage units

    @property
    def frequency(self) -> float:
        """The natural frequency [1/s] of a critically damped motion to the target; 0 if nothing pulls there."""
        if self.stiffness <= 0.0:
            return 0.0
        return 2.0 * self.stiffness / self.damping if self.damping > 0.0 else float(np.sqrt(self.stiffness))


class Articulation:
    """The joints of one robot, which physics moves while it plays.

    Joints that are not simulated move by their velocities and drives within their limits, and
    nothing pushes them: one with a stiff drive approaches its target without overshoot, at the drive's rate of
    2 stiffness / damping; one without keeps its velocity, or takes the drive's target velocity.
    """

    def __init__(self, stage: Usd.Stage, root: str) -> None:
        """Read the robot below the prim at `root`.

        Raises:
            BadPrim: there is no joint between two bodies.
        """
        self._stage = stage
        self.tree = JointTree(stage, root)
        self._paths = [joint.path for joint in self.dofs]
        self._positions = self.tree.positions()
        self._velocities = np.zeros(len(self.dofs))
        self._given_velocities = False  # to the next play
        self._was_simulated = False
        self._first = self._positions.copy()
        self._touching: Callable[[Collection[str]], set[str]] | None = None

    @property
    def root(self) -> str:
        """The path of its prim."""
        return self.tree.root

    @property
    def dofs(self) -> Sequence[Joint]:
        """The joints with a position, breadth first from the base."""
        return self.tree.dofs

    @property
    def positions(self) -> Array:
        """The positions (D,) of the joints [rad, stage units]."""
        engine = self._engine()
        return self._positions if engine is None else engine.joint_positions(self._paths)

    @property
    def velocities(self) -> Array:
        """The velocities (D,) of the joints [rad/s, stage units/s]."""
        engine = self._engine()
        return self._velocities if engine is None else engine.joint_velocities(self._paths)

    def set_positions(self, positions: ArrayLike) -> None:
        """Move the joints (D,) at once, within their limits; their velocities stay."""
        self._positions = self._limited(np.asarray(positions, np.float64))
        self._follow_leaders()
        if (engine := self._engine()) is not None:
            engine.set_joint_state(self._paths, self._positions)
        else:
            self._show()

    def set_velocities(self, velocities: ArrayLike) -> None:
        """Set the velocities (D,) [rad/s, stage units/s] from the next step on."""
        self._velocities = np.array(velocities, np.float64)
        if (engine := self._engine()) is not None:
            engine.set_joint_state(self._paths, velocities=self._velocities)
        else:
            self._given_velocities = True

    def apply_efforts(self, efforts: ArrayLike) -> None:
        """Push the joints (D,) during the next step: torques, and forces of prismatic joints, in stage units.

        Raises:
            PhysicsError: physics does not play, or does not simulate all joints.
        """
        engine = self._engine()
        if engine is None:
            raise PhysicsError(f"{self.root}: no effort acts on its joints, because they are not simulated; play first")
        engine.apply_joint_efforts(self._paths, efforts)

    def joint_forces(self) -> Array:
        """Return the forces and torques (1 + J, 6) in the joints between links, breadth first; see `joint_forces` of
        the physics engine.

        The first row is of the joint that holds the base, which PhysX does not measure: zeros.

        Raises:
            PhysicsError: physics does not play, or does not simulate all joints.
        """
        engine = self._engine()
        if engine is None:
            raise PhysicsError(f"{self.root}: no force acts in its joints, because they are not simulated; play first")
        paths = [branch.joint.path for branch in self.tree.branches]
        return np.vstack([np.zeros((1, 6)), engine.joint_forces(paths)])

    def measure(self) -> None:
        """Take the positions of the links on the stage, at rest."""
        self._positions = self.tree.positions()
        self._velocities = np.zeros(len(self.dofs))

    def restart(self) -> None:
        """Return to the positions that it was made with."""
        self.set_velocities(np.zeros(len(self.dofs)))
        self.set_positions(self._first)

    def stop_before(self, touching: Callable[[Collection[str]], set[str]] | None) -> None:
        """Let a joint stay where it is if a link that it moves would be in `touching(links)`; None lets all move.

        Joints that physics simulates stop where links touch anything.
        """
        self._touching = touching

    def step(self, dt: float) -> None:
        """Advance by `dt` seconds and place the links; physics does so itself with joints that it simulates."""
        if (engine := self._engine()) is not None:
            if self._given_velocities:
                engine.set_joint_state(self._paths, velocities=self._velocities)
            self._given_velocities = False
            return
        before = self._positions.copy()
        for index, joint in enumerate(self.dofs):
            self._positions[index], self._velocities[index] = self._advanced(index, joint, dt)
        moved = self._limited(self._positions)
        self._velocities[moved != self._positions] = 0.0
        self._positions = moved
        self._follow_leaders()
        if np.array_equal(before, self._positions):
            return
        self._show()
        if self._touching is not None and (touched := self._touching(self.tree.links)):
            self._take_back(before, touched)

    def _engine(self) -> engines.PhysicsEngine | None:
        """Return the physics engine if it plays and simulates all joints."""
        engine = engines.physics_if_made()
        if engine is not None and engine.is_playing and self._paths and set(self._paths) <= set(engine.joints):
            self._was_simulated = True
            return engine
        if self._was_simulated:
            self._was_simulated = False
            self.measure()
        return None

    def _take_back(self, before: Array, touched: set[str]) -> None:
        """Move the joints of touched links, with the leaders that they follow, only as far as nothing is touched."""
        leaders = self._leaders()
        moving = [row for row, joint in enumerate(self.dofs) if touched & self.tree.moved_by(joint)]
        rows = sorted({each for row in moving for each in (row, leaders.get(row, (row, 0.0, 0.0))[0])})
        moved, self._velocities[rows] = self._positions.copy(), 0.0
        free, reached = 0.0, 1.0
        for _ in range(_HALVINGS):
            middle = (free + reached) / 2.0
            self._part_way(rows, before, moved, middle)
            touches = self._touching is not None and self._touching(self.tree.links) & touched
            free, reached = (free, middle) if touches else (middle, reached)
        self._part_way(rows, before, moved, free)

    def _part_way(self, rows: list[int], before: Array, moved: Array, part: float) -> None:
        """Place joints part of the way, from 0 to 1, between two positions."""
        self._positions[rows] = before[rows] + part * (moved[rows] - before[rows])
        self._follow_leaders()
        self._show()

    def _advanced(self, index: int, joint: Joint, dt: float) -> tuple[float, float]:
        position, velocity = self._positions[index], self._velocities[index]
        drive = read_drive(self._stage, joint)
        if (omega := drive.frequency) > 0.0:
            # The closed form of a critically damped spring.
            offset = position - drive.target
            rate, decay = velocity + omega * offset, np.exp(-omega * dt)
            position = drive.target + (offset + rate * dt) * decay
            velocity = (velocity - omega * rate * dt) * decay
        else:
            velocity = drive.target_velocity if drive.damping > 0.0 else velocity
            position = position + velocity * dt
        most = self._max_velocity(joint) * dt
        before = self._positions[index]
        return float(np.clip(position, before - most, before + most)), float(np.clip(velocity, -most / dt, most / dt))

    def _max_velocity(self, joint: Joint) -> float:
        attribute = self._stage.GetPrimAtPath(joint.path).GetAttribute("physxJoint:maxJointVelocity")
        value = attribute.Get() if attribute and attribute.HasAuthoredValue() else None
        return float(value) * joint.unit if value is not None and value > 0.0 else np.inf

    def _limited(self, positions: Array) -> Array:
        limits = np.array([limits_of(self._stage, joint) for joint in self.dofs]).reshape(-1, 2)
        return np.clip(positions, limits[:, 0], np.maximum(limits[:, 0], limits[:, 1]))

    def _follow_leaders(self) -> None:
        """Place mimic joints: position + gearing times the leader's + offset is zero."""
        leaders = self._leaders()
        for _ in range(len(leaders)):  # one that leads may follow another one
            before = self._positions.copy()
            for index, (leader, gearing, offset) in leaders.items():
                self._positions[index] = -gearing * before[leader] - offset
            if np.array_equal(before, self._positions):
                return

    def _leaders(self) -> dict[int, tuple[int, float, float]]:
        """Return the leader, gearing and offset [rad, stage units] of each mimic joint, by number."""
        number = {joint.path: index for index, joint in enumerate(self.dofs)}
        found = {}
        for index, joint in enumerate(self.dofs):
            prim = self._stage.GetPrimAtPath(joint.path)
            for schema in (name for name in prim.GetAppliedSchemas() if name.startswith(_MIMIC)):
                prefix = f"physxMimicJoint:{schema.removeprefix(_MIMIC)}"
                leader = prim.GetRelationship(f"{prefix}:referenceJoint").GetTargets()
                if leader and str(leader[0]) in number:
                    row = number[str(leader[0])]
                    # Per degree or stage unit of the leader.
                    unit = joint.unit / self.dofs[row].unit
                    gearing = float(prim.GetAttribute(f"{prefix}:gearing").Get()) * unit
                    offset = float(prim.GetAttribute(f"{prefix}:offset").Get()) * joint.unit
                    found[index] = row, gearing, offset
        return found

    def _show(self) -> None:
        """Write poses of links, and the states of joints that have JointStateAPI, to the stage."""
        self.tree.place(self._positions)
        for joint, position, velocity in zip(self.dofs, self._positions, self._velocities):
            prim = self._stage.GetPrimAtPath(joint.path)
            for name, value in (("position", position), ("velocity", velocity)):
                attribute = prim.GetAttribute(f"state:{joint.drive}:physics:{name}")
                if attribute:
                    attribute.Set(float(value / joint.unit))


def read_drive(stage: Usd.Stage, joint: Joint) -> Drive:
    """Read a joint's drive as it is now; one without a drive has zeros."""
    api = drive_of(stage, joint)
    if not api:
        return Drive(0.0, 0.0, 0.0, 0.0)
    stiffness, damping, target, velocity = (
        float(attribute.Get() or 0.0)
        for attribute in (
            api.GetStiffnessAttr(),
            api.GetDampingAttr(),
            api.GetTargetPositionAttr(),
            api.GetTargetVelocityAttr(),
        )
    )
    found = api.GetMaxForceAttr().Get()
    return Drive(
        stiffness / joint.unit,
        damping / joint.unit,
        target * joint.unit,
        velocity * joint.unit,
        np.inf if found is None else float(found),
    )


def limits_of(stage: Usd.Stage, joint: Joint) -> tuple[float, float]:
    """Return the limits of a joint's position as they are now."""
    prim = stage.GetPrimAtPath(joint.path)
    lower, upper = (prim.GetAttribute(f"physics:{end}Limit").Get() for end in ("lower", "upper"))
    return float(lower) * joint.unit, float(upper) * joint.unit
