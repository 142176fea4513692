"""`SingleArticulation`: one robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.compat.isaacsim.core.prims.articulation import Articulation
from usdsdg.compat.isaacsim.core.prims.single_xform_prim import SingleXFormPrim
from usdsdg.compat.isaacsim.core.utils.types import ArticulationAction, JointsState
from usdsdg.compat.wrappers.bindings import wrapper_class
from usdsdg.compat.wrappers.joints.rows import WHY
from usdsdg.compat.wrappers.prim_paths import existing_prim
from usdsdg.compat.wrappers.unsupported import RefusedNames

if TYPE_CHECKING:
    from usdsdg.compat.isaacsim.core.api.controllers.articulation_controller import ArticulationController
    from usdsdg.compat.wrappers.arrays import Indices, Values

_DOF_PROPERTIES = [
    ("type", int), ("hasLimits", bool), ("lower", float), ("upper", float), ("driveMode", int), ("maxVelocity", float),
    ("maxEffort", float), ("stiffness", float), ("damping", float),
]  # fmt: skip


class SingleArticulation(SingleXFormPrim):
    """One robot; see `Articulation`, whose arrays have one dimension more. D is the number of joints."""

    __getattr__ = RefusedNames("SingleArticulation", ("get_", "set_", "apply_"), WHY)

    _robots: Articulation

    def __init__(
        self,
        prim_path: str,
        name: str = "articulation",
        position: Sequence[float] | None = None,
        translation: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
        scale: Sequence[float] | None = None,
        visible: bool | None = None,
        reset_xform_properties: bool = True,
        articulation_controller: ArticulationController | None = None,
    ) -> None:
        """Wrap a prim at or below which there are links and joints; see `SingleXFormPrim`.

        Args:
            articulation_controller: What `apply_action` uses; by default an `ArticulationController`.

        Raises:
            BadPrim: there is no such prim.
        """
        existing_prim(prim_path)
        super().__init__(prim_path, name, position, translation, orientation, scale, visible, reset_xform_properties)
        # Controllers import what is here, so they are imported when a robot is made.
        make = wrapper_class("api.controllers:ArticulationController")
        self._articulation_controller: ArticulationController = articulation_controller or make()

    def _make_view(self, *args: object) -> Articulation:
        self._robots = Articulation(*args)  # pyright: ignore[reportArgumentType]
        return self._robots

    # --- what there is ---
    @property
    def handles_initialized(self) -> bool:
        """Whether physics simulates, and `initialize` has been called."""
        return self._robots.is_physics_handle_valid() and self._articulation_controller.is_initialized

    @property
    def num_dof(self) -> int:
        return self._robots.num_dof

    @property
    def num_bodies(self) -> int:
        return self._robots.num_bodies

    @property
    def dof_names(self) -> list[str]:
        """Return the names of the joints with a position, breadth first from the base."""
        return self._robots.dof_names

    @property
    def dof_properties(self) -> np.ndarray:
        """A record array (D,) of type, hasLimits, lower, upper, driveMode, maxVelocity, maxEffort, stiffness, damping.

        Types are 1 (rotation) and 2 (translation), drive modes 0 (no drive), 1 (force) and 2 (acceleration).
        """
        view, found = self._robots, np.zeros(self.num_dof, _DOF_PROPERTIES)
        found["type"] = [1 + int(each) for each in view.get_dof_types()]
        limits = np.asarray(view.get_dof_limits())[0]
        found["lower"], found["upper"] = limits[:, 0], limits[:, 1]
        # Limits that are both 0 are none.
        found["hasLimits"] = np.isfinite(limits).all(axis=1) & limits.any(axis=1)
        found["driveMode"] = np.asarray(view.get_drive_types())[0]
        found["maxVelocity"] = np.asarray(view.get_joint_max_velocities())[0]
        found["maxEffort"] = np.asarray(view.get_max_efforts())[0]
        found["stiffness"], found["damping"] = (np.asarray(each)[0] for each in view.get_gains())
        return found

    def get_dof_index(self, dof_name: str) -> int:
        """Return the column of a joint.

        Raises:
            KeyError: there is no such joint.
        """
        return self._robots.get_dof_index(dof_name)

    def get_articulation_body_count(self) -> int:
        return self._robots.num_bodies

    def initialize(self, physics_sim_view: object = None) -> None:
        """Take the present targets and gains as those of `post_reset`, and let the controller take the robot."""
        self._robots.initialize(physics_sim_view)
        self._articulation_controller.initialize(self._robots)

    def post_reset(self) -> None:
        """Place the robot and its joints as their default states say; see `Articulation.post_reset`."""
        super().post_reset()
        self._articulation_controller.initialize(self._robots)

    # --- joints ---
    def get_joint_positions(self, joint_indices: Indices = None) -> np.ndarray:
        """Return (D,) [rad, stage units]."""
        return self._robots.get_joint_positions(joint_indices=joint_indices)[0]

    def set_joint_positions(self, positions: Values, joint_indices: Indices = None) -> None:
        """Move joints at once, within their limits: (D,)."""
        self._robots.set_joint_positions(positions, joint_indices=joint_indices)

    def get_joint_velocities(self, joint_indices: Indices = None) -> np.ndarray:
        """Return (D,) [rad/s, stage units/s]."""
        return self._robots.get_joint_velocities(joint_indices=joint_indices)[0]

    def set_joint_velocities(self, velocities: Values, joint_indices: Indices = None) -> None:
        """Set velocities (D,), which last until a limit, or as the joint's drive damps them."""
        self._robots.set_joint_velocities(velocities, joint_indices=joint_indices)

    def set_joint_efforts(self, efforts: Values, joint_indices: Indices = None) -> None:
        """Push joints during the next physics step: torques, and forces of prismatic joints (D,).

        Raises:
            PhysicsError: physics does not play.
        """
        self._robots.set_joint_efforts(efforts, joint_indices=joint_indices)

    def get_applied_joint_efforts(self, joint_indices: Indices = None) -> np.ndarray:
        """Return the efforts (D,) that were set last; those of drives are not among them."""
        return self._robots.get_applied_joint_efforts(joint_indices=joint_indices)[0]

    def get_measured_joint_efforts(self, joint_indices: Indices = None) -> np.ndarray:
        """Return what joints bore along their axes (D,), see `Articulation.get_measured_joint_efforts`."""
        return self._robots.get_measured_joint_efforts(joint_indices=joint_indices)[0]

    def get_measured_joint_forces(self, joint_indices: Indices = None) -> np.ndarray:
        """Return what joints bore (1 + J, 6), see `Articulation.get_measured_joint_forces`."""
        return self._robots.get_measured_joint_forces(joint_indices=joint_indices)[0]

    def get_joints_state(self) -> JointsState:
        """Return positions and velocities (D,)."""
        return JointsState(self.get_joint_positions(), self.get_joint_velocities(), None)

    def get_joints_default_state(self) -> JointsState:
        """Return the positions and velocities (D,) that `post_reset` gives joints."""
        state = self._robots.get_joints_default_state()
        return JointsState(np.asarray(state.positions)[0], np.asarray(state.velocities)[0], None)

    def set_joints_default_state(
        self, positions: Values | None = None, velocities: Values | None = None, efforts: Values | None = None
    ) -> None:
        """Set the positions, velocities and efforts (D,) that `post_reset` gives joints; what is not given stays."""
        self._robots.set_joints_default_state(positions, velocities, efforts)

    # --- control ---
    def get_articulation_controller(self) -> ArticulationController:
        """Return the controller, initialized if it was not."""
        if not self._articulation_controller.is_initialized:
            self._articulation_controller.initialize(self._robots)
        return self._articulation_controller

    def apply_action(self, control_actions: ArticulationAction) -> None:
        """Set targets and efforts; see `ArticulationController.apply_action`."""
        self.get_articulation_controller().apply_action(control_actions)

    def get_applied_action(self) -> ArticulationAction:
        """Return the targets of the drives, and the efforts that were set last (D,)."""
        return self.get_articulation_controller().get_applied_action()

    # --- velocities of the base ---
    def get_world_velocity(self) -> np.ndarray:
        """Return (6,): linear [stage units/s], then angular velocity [rad/s]."""
        return self._robots.get_velocities()[0]

    def set_world_velocity(self, velocity: Values) -> None:
        """Set (6,): linear [stage units/s], then angular velocity [rad/s]; links move along."""
        self._robots.set_velocities(velocity)

    def get_linear_velocity(self) -> np.ndarray:
        """Return (3,) [stage units/s]."""
        return self._robots.get_linear_velocities()[0]

    def set_linear_velocity(self, velocity: Values) -> None:
        self._robots.set_linear_velocities(velocity)

    def get_angular_velocity(self) -> np.ndarray:
        """Return (3,) [rad/s]."""
        return self._robots.get_angular_velocities()[0]

    def set_angular_velocity(self, velocity: Values) -> None:
        self._robots.set_angular_velocities(velocity)

    # --- switches ---
    def enable_gravity(self) -> None:
        self._robots.set_body_disable_gravity(np.zeros(self.num_bodies))

    def disable_gravity(self) -> None:
        self._robots.set_body_disable_gravity(np.ones(self.num_bodies))

    def set_enabled_self_collisions(self, flag: bool) -> None:
        """Let links collide with each other, or not."""
        self._robots.set_enabled_self_collisions(flag)

    def get_enabled_self_collisions(self) -> int:
        return int(self._robots.get_enabled_self_collisions()[0])

    def set_solver_position_iteration_count(self, count: int) -> None:
        self._robots.set_solver_position_iteration_counts(count)

    def get_solver_position_iteration_count(self) -> int:
        return int(self._robots.get_solver_position_iteration_counts()[0])

    def set_solver_velocity_iteration_count(self, count: int) -> None:
        self._robots.set_solver_velocity_iteration_counts(count)

    def get_solver_velocity_iteration_count(self) -> int:
        return int(self._robots.get_solver_velocity_iteration_counts()[0])

    def set_stabilization_threshold(self, threshold: float) -> None:
        self._robots.set_stabilization_thresholds(threshold)

    def get_stabilization_threshold(self) -> float:
        return float(self._robots.get_stabilization_thresholds()[0])

    def set_sleep_threshold(self, threshold: float) -> None:
        self._robots.set_sleep_thresholds(threshold)

    def get_sleep_threshold(self) -> float:
        return float(self._robots.get_sleep_thresholds()[0])
