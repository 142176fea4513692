"""The phases of a `GraspingManager`, by number and by name."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from usdsdg.compat.isaacsim.replicator.grasping.grasp_phase import (
    DEFAULT_NUM_SIMULATION_STEPS,
    DEFAULT_SIMULATION_STEP_DT,
    GraspPhase,
)


class PhaseList:
    """Adds, removes and finds the phases of closing a gripper."""

    grasp_phases: list[GraspPhase]

    def create_and_add_grasp_phase(
        self,
        name: str,
        joint_drive_targets: dict[str, float] | None = None,
        simulation_steps: int = DEFAULT_NUM_SIMULATION_STEPS,
        simulation_step_dt: float = DEFAULT_SIMULATION_STEP_DT,
    ) -> GraspPhase:
        """Append a phase and return it."""
        phase = GraspPhase(name, dict(joint_drive_targets or {}), simulation_steps, simulation_step_dt)
        self.grasp_phases.append(phase)
        return phase

    def remove_grasp_phase_by_name(self, phase_name: str) -> bool:
        """Remove the first phase of a name; return whether there is one."""
        phase = self.get_grasp_phase_by_name(phase_name)
        if phase is not None:
            self.grasp_phases.remove(phase)
        return phase is not None

    def get_grasp_phase_by_name(self, name: str, ignore_case: bool = True) -> GraspPhase | None:
        """Return the first phase of a name, or None."""
        same = (lambda a, b: a.lower() == b.lower()) if ignore_case else (lambda a, b: a == b)
        return next((phase for phase in self.grasp_phases if same(phase.name, name)), None)

    def get_grasp_phase_by_index(self, index: int) -> GraspPhase | None:
        """Return the phase of a number, or None."""
        return self.grasp_phases[index] if 0 <= index < len(self.grasp_phases) else None

    def get_grasp_phases_as_dicts(self) -> list[dict[str, Any]]:
        return [asdict(phase) for phase in self.grasp_phases]

    def get_grasp_phase_names(self) -> list[str]:
        return [phase.name for phase in self.grasp_phases]
