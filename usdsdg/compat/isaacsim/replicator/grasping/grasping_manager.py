"""`isaacsim.replicator.grasping.grasping_manager`: sample grasps and close a gripper at each."""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable, Sequence
from typing import Any

from pxr import Gf, Sdf, Usd

from usdsdg.compat.isaacsim.replicator.grasping import config_file, grasping_utils, transform_utils
from usdsdg.compat.isaacsim.replicator.grasping.grasp_phase import (
    DEFAULT_NUM_SIMULATION_STEPS,
    DEFAULT_SIMULATION_STEP_DT,
    GraspPhase,
)
from usdsdg.compat.isaacsim.replicator.grasping.grasp_results import GraspResults
from usdsdg.compat.isaacsim.replicator.grasping.gripper import close_around
from usdsdg.compat.isaacsim.replicator.grasping.phase_list import PhaseList
from usdsdg.session.stage_context import current_stage

__all__ = [
    "DEFAULT_NUM_SIMULATION_STEPS", "DEFAULT_SAMPLER_CONFIG", "DEFAULT_SIMULATION_STEP_DT", "GraspPhase",
    "GraspingManager",
]  # fmt: skip

Pose = tuple[Gf.Vec3d, Gf.Quatd]

_log = logging.getLogger("usdsdg.script")

DEFAULT_SAMPLER_CONFIG: dict[str, Any] = {
    "sampler_type": "antipodal",
    "num_candidates": 100,
    "num_orientations": 1,
    "gripper_maximum_aperture": 0.08,
    "gripper_standoff_fingertips": 0.17,
    "gripper_approach_direction": (0, 0, 1),
    "grasp_align_axis": (0, 1, 0),
    "orientation_sample_axis": (0, 1, 0),
    "lateral_sigma": 0.0,
    "random_seed": -1,
    "verbose": False,
}


class GraspingManager(PhaseList, GraspResults):
    """A gripper, an object, poses of the gripper relative to the object, and the phases of closing.

    The joints of the gripper go to the targets of each phase, and stay where a finger would overlap the object: results
    tell how far the gripper closes, not whether it holds.
    """

    def __init__(self) -> None:
        self._initial_pose: Pose | None = None
        self._stop_requested = False
        self._forget()

    def _forget(self) -> None:
        self.grasp_locations: list[Gf.Vec3d] = []
        self.grasp_orientations: list[Gf.Quatd] = []
        self.grasp_phases: list[GraspPhase] = []
        self.object_simulation_phases: list[Any] = []
        self.joint_pregrasp_states: dict[str, float] = {}
        self.sampler_config: dict[str, Any] = dict(DEFAULT_SAMPLER_CONFIG)
        self._gripper: Usd.Prim | None = None
        self._object_path: str | None = None

    def clear(self) -> None:
        """End the simulation, and forget poses, phases, gripper and object."""
        grasping_utils.reset_physics_simulation()
        grasping_utils.stop_timeline()
        self._stop_requested = False
        self._forget()

    def clear_simulation(self, simulate_using_timeline: bool) -> None:
        """End the simulation of one kind; bodies and joints return to where they were."""
        if simulate_using_timeline:
            grasping_utils.stop_timeline()
        else:
            grasping_utils.reset_physics_simulation()

    # --- gripper and object ---
    def set_gripper(self, gripper: str | Usd.Prim | None) -> bool:
        """Set the gripper by path or prim; return whether it exists."""
        if isinstance(gripper, str):
            gripper = current_stage().GetPrimAtPath(gripper) if Sdf.Path.IsValidPathString(gripper) else None
        self._gripper = gripper if gripper else None
        self.joint_pregrasp_states.clear()
        return self._gripper is not None

    @property
    def gripper_path(self) -> str:
        """The path of the gripper, empty if there is none."""
        return str(self._gripper.GetPath()) if self._gripper else ""

    @gripper_path.setter
    def gripper_path(self, path: str) -> None:
        self.set_gripper(path)

    @property
    def gripper_prim(self) -> Usd.Prim | None:
        return self._gripper

    def clear_gripper(self) -> None:
        self.set_gripper(None)

    def set_object_prim_path(self, path: str | None) -> None:
        self._object_path = path

    def get_object_prim_path(self) -> str | None:
        return self._object_path

    @property
    def object_path(self) -> str | None:
        """The path of the object, as `set_object_prim_path` sets it."""
        return self._object_path

    @object_path.setter
    def object_path(self, path: str | None) -> None:
        self._object_path = path

    def get_object_prim(self) -> Usd.Prim | None:
        """Return the object; None, with a warning, where there is none."""
        path = self._object_path
        prim = current_stage().GetPrimAtPath(path) if path and Sdf.Path.IsValidPathString(path) else None
        if not prim:
            _log.warning("grasping: there is no object at %s", path)
            return None
        return prim

    def clear_object(self) -> None:
        self._object_path = None

    def set_gripper_pose(self, location: Gf.Vec3d, orientation: Gf.Quatd) -> None:
        """Set the translate and orient ops of the gripper: its pose in the world if its parents have none."""
        if not self._gripper:
            _log.warning("grasping: there is no gripper to move")
            return
        transform_utils.set_transform_attributes(self._gripper, location=location, orientation=orientation)

    def store_initial_gripper_pose(self, location: Gf.Vec3d | None = None, orientation: Gf.Quatd | None = None) -> None:
        """Remember where the gripper returns to after an evaluation: the pose given, or where it is."""
        if location is not None and orientation is not None:
            self._initial_pose = location, orientation
        else:
            self._initial_pose = transform_utils.get_prim_world_pose(self._gripper) if self._gripper else None

    def get_initial_gripper_pose(self) -> Pose | None:
        """Return the pose to return to; where none is stored, that of the gripper, which is stored."""
        if self._initial_pose is None:
            self.store_initial_gripper_pose()
        return self._initial_pose

    def update_joint_pregrasp_states_from_current(self, joint_info_list: list[dict] | None = None) -> None:
        """Take the positions of the gripper's joints, or of those in a list of mappings with "path"."""
        joints = (
            grasping_utils.get_gripper_joints_info(self.gripper_path) if joint_info_list is None else joint_info_list
        )
        paths = [joint["path"] for joint in joints]
        self.joint_pregrasp_states = grasping_utils.populate_joint_pregrasp_states_from_current(paths)

    # --- configuration files ---
    def save_config(self, file_path: str, components: list[str] | None = None, overwrite: bool = False) -> None:
        """Write a YAML file.

        Args:
            components: of "gripper", "phases", "object", "pregrasp", "poses" and "sampler"; None for all.
            overwrite: replace an existing file; otherwise it stays, with a warning.
        """
        config = config_file.to_mapping(self, components)
        if not config:
            _log.warning("grasping: there is nothing to save")
            return
        grasping_utils.write_yaml_config(file_path, config, overwrite=overwrite)

    def load_config(self, file_path: str, components: list[str] | None = None) -> dict[str, str]:
        """Read a YAML file; return what became of each component: "Success", "Not in file", or "Failed (...)"."""
        return config_file.load(self, grasping_utils.read_yaml_config(file_path), components)

    # --- poses ---
    def generate_grasp_poses(self, config: dict[str, Any] | None = None) -> bool:
        """Sample poses relative to the object, by `sampler_config` or another; return whether there are any.

        Raises:
            ArgumentError: (a ValueError) the configuration is wrong.
        """
        prim = self.get_object_prim()
        poses = grasping_utils.generate_grasp_poses_from_config(prim, config or self.sampler_config) if prim else None
        self.clear_grasp_poses()
        if not poses:
            _log.warning("grasping: no poses were found for %s", self._object_path)
            return False
        self.grasp_locations = [location for location, _ in poses]
        self.grasp_orientations = [orientation for _, orientation in poses]
        return True

    def clear_grasp_poses(self) -> None:
        self.grasp_locations, self.grasp_orientations = [], []

    def get_grasp_poses(self, in_world_frame: bool = False) -> list[Pose]:
        """Return the poses relative to the object, or those in the world for where the object is now."""
        poses = list(zip(self.grasp_locations, self.grasp_orientations))
        if not in_world_frame or not poses:
            return poses
        prim = self.get_object_prim()
        return transform_utils.transform_local_poses_to_world(poses, prim) if prim else []

    def get_grasp_pose_at_index(self, index: int, in_world_frame: bool = False) -> Pose | None:
        """Return one of `get_grasp_poses`; None, with a warning, where there is none of this number."""
        poses = self.get_grasp_poses(in_world_frame)
        if not 0 <= index < len(poses):
            _log.warning("grasping: there is no pose %s; there are %s", index, len(poses))
            return None
        return poses[index]

    def move_gripper_to_grasp_pose(self, index: int, in_world_frame: bool = True) -> None:
        """Set the pose of the gripper to one of `get_grasp_poses`."""
        if (pose := self.get_grasp_pose_at_index(index, in_world_frame)) is not None:
            self.set_gripper_pose(*pose)

    # --- evaluation ---
    def request_workflow_stop(self) -> None:
        """Let `evaluate_grasp_poses` end before its next pose."""
        self._stop_requested = True

    async def evaluate_grasp_poses(
        self,
        grasp_poses: Sequence[Pose],
        render: bool = True,
        physics_scene_path: str | None = None,
        isolate_simulation: bool = False,
        simulate_using_timeline: bool = False,
        progress_callback: Callable[[int], Awaitable[None]] | None = None,
    ) -> None:
        """Evaluate poses in the world one after the other, then return the gripper to its initial pose.

        Args:
            progress_callback: awaited with the number of poses that have been evaluated.
        """
        initial = self.get_initial_gripper_pose()
        self._results, self._stop_requested = 0, False
        for number, pose in enumerate(grasp_poses, 1):
            if self._stop_requested:
                break
            print(f"grasp {number} of {len(grasp_poses)}")
            await self.evaluate_grasp_pose(
                *pose,
                render=render,
                physics_scene_path=physics_scene_path,
                isolate_simulation=isolate_simulation,
                simulate_using_timeline=simulate_using_timeline,
            )
            if progress_callback is not None:
                await progress_callback(number)
        self.clear_simulation(simulate_using_timeline)
        if initial is not None:
            self.set_gripper_pose(*initial)
        self._stop_requested = False

    async def evaluate_grasp_pose(
        self,
        location: Gf.Vec3d,
        orientation: Gf.Quatd,
        clear_simulation: bool = True,
        render: bool = True,
        physics_scene_path: str | None = None,
        isolate_simulation: bool = False,
        simulate_using_timeline: bool = False,
    ) -> None:
        """Move the gripper to a pose in the world, simulate all phases, and write the result."""
        if clear_simulation:
            self.clear_simulation(simulate_using_timeline)
        self.set_gripper_pose(location, orientation)
        await self.simulate_all_grasp_phases(render, physics_scene_path, isolate_simulation, simulate_using_timeline)
        self.write_grasp_results(location, orientation)

    async def evaluate_grasp_pose_by_index(
        self,
        index: int,
        render: bool = True,
        physics_scene_path: str | None = None,
        isolate_simulation: bool = False,
        simulate_using_timeline: bool = False,
    ) -> None:
        """Evaluate one of the poses that are stored."""
        if (pose := self.get_grasp_pose_at_index(index, in_world_frame=True)) is not None:
            await self.evaluate_grasp_pose(
                *pose,
                render=render,
                physics_scene_path=physics_scene_path,
                isolate_simulation=isolate_simulation,
                simulate_using_timeline=simulate_using_timeline,
            )

    async def simulate_all_grasp_phases(
        self,
        render: bool = True,
        physics_scene_path: str | None = None,
        isolate_simulation: bool = False,
        simulate_using_timeline: bool = False,
    ) -> bool:
        """Set the targets of each phase and simulate its steps; return False, with a warning, if there are no phases.

        Args:
            render: an app update after every step.
            physics_scene_path: of the PhysicsScene to simulate; the first one is simulated in any case.
            isolate_simulation: not available: all bodies are simulated together.
            simulate_using_timeline: play the timeline instead of single steps.
        """
        if not self.grasp_phases:
            _log.warning("grasping: there are no phases to simulate")
            return False
        for phase in self.grasp_phases:
            await self._simulate(phase, render, physics_scene_path, isolate_simulation, simulate_using_timeline)
        return True

    async def simulate_single_grasp_phase(
        self,
        phase_identifier: str | int,
        render: bool = True,
        physics_scene_path: str | None = None,
        isolate_simulation: bool = False,
        simulate_using_timeline: bool = False,
    ) -> bool:
        """Simulate one phase by name or number; return False, with a warning, where there is none."""
        if isinstance(phase_identifier, int):
            phase = self.get_grasp_phase_by_index(phase_identifier)
        else:
            phase = self.get_grasp_phase_by_name(phase_identifier)
        if phase is None:
            _log.warning("grasping: there is no phase %s", phase_identifier)
            return False
        await self._simulate(phase, render, physics_scene_path, isolate_simulation, simulate_using_timeline)
        return True

    async def _simulate(
        self, phase: GraspPhase, render: bool, scene_path: str | None, isolate: bool, use_timeline: bool
    ) -> None:
        stage = current_stage()
        if self.gripper_path and self._object_path:
            close_around(self.gripper_path, self._object_path)
        for path, target in phase.joint_drive_targets.items():
            grasping_utils.set_joint_drive_parameters(stage.GetPrimAtPath(path), target_value=target)
        if use_timeline:
            await grasping_utils.advance_timeline_async(phase.simulation_steps, render)
            return
        scene = grasping_utils.get_physics_scene(stage, scene_path) if scene_path else None
        isolated = []
        if isolate and scene:
            isolated = grasping_utils.isolate_prims_to_scene(list(filter(None, self._prims())), scene)
        await grasping_utils.simulate_physics_async(phase.simulation_steps, phase.simulation_step_dt, scene, render)
        grasping_utils.clear_isolated_simulation_owners(isolated, scene)

    def _prims(self) -> list[Usd.Prim | None]:
        return [self._gripper, self.get_object_prim()]
