"""One phase of a grasp: where its joints go, and how long it takes."""

from __future__ import annotations

from dataclasses import dataclass, field

DEFAULT_NUM_SIMULATION_STEPS = 32
DEFAULT_SIMULATION_STEP_DT = 1 / 60


@dataclass
class GraspPhase:
    """A phase; targets are those of the joints' drives by path: degrees of revolute joints, stage units of others."""

    name: str
    joint_drive_targets: dict[str, float] = field(default_factory=dict)
    simulation_steps: int = DEFAULT_NUM_SIMULATION_STEPS
    simulation_step_dt: float = DEFAULT_SIMULATION_STEP_DT  # s

    def add_joint(self, joint_path: str, target_position: float = 0) -> None:
        self.joint_drive_targets[joint_path] = target_position

    def remove_joint(self, joint_path: str) -> None:
        """Leave a joint out; nothing if it is not in the phase."""
        self.joint_drive_targets.pop(joint_path, None)

    def has_joint(self, joint_path: str) -> bool:
        return joint_path in self.joint_drive_targets

    def get_joint_target(self, joint_path: str) -> float:
        """Return the target of a joint, 0 if it is not in the phase."""
        return self.joint_drive_targets.get(joint_path, 0)
