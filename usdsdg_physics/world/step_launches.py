"""The kernel launches of a step: contacts, what corrects them, the solver, and what corrects its result."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from usdsdg_physics.solver.visited_contacts import VisitedContacts
from usdsdg_physics.world.compile_kernels import Progress, load_launched_kernels
from usdsdg_physics.world.kinematic_motion import KinematicMotion
from usdsdg_physics.world.step_corrections import StepCorrections, StepKind
from usdsdg_physics.world.step_records import StepRecords

if TYPE_CHECKING:
    import newton

    from usdsdg_physics.world.joints import Joints

# What a state holds that a step changes.
CHANGING = ("joint_q", "joint_qd", "body_q", "body_qd")


class StepLaunches:
    """Launches the kernels of steps, or replays what it has recorded of steps of the same kind.

    What is launched may be recorded, so nothing in it depends on what arrays hold. The number of contacts is looked at
    between finding them and solving them, where that costs nothing: on the CPU.
    """

    def __init__(
        self,
        states: tuple[newton.State, newton.State],
        control: newton.Control,
        contacts: newton.Contacts,
        *,
        pipeline: newton.CollisionPipeline,
        solver: Any,
        corrections: StepCorrections,
        kinematic: KinematicMotion,
        joints: Joints | None,
        extra_contacts: int,
    ) -> None:
        """Steps begin and end in the first of the `states`; `extra_contacts` is how many corrections may add."""
        self._state, self._next = states
        self._control, self._contacts = control, contacts
        self._pipeline, self._solver, self._corrections = pipeline, solver, corrections
        self._kinematic, self._joints = kinematic, joints
        self._observables = solver.observables(corrections.observables, contacts=contacts)
        self._visited = VisitedContacts.of(solver, contacts, extra=extra_contacts)
        self.forget()

    def forget(self) -> None:
        """Forget the records, since steps launch other kernels or have other arrays than before."""
        self.records = StepRecords(self._solver.model.device)

    def run(self, kind: StepKind) -> None:
        """Take a step of a kind."""
        if self._visited is None:
            self.records.run(kind, lambda: self._launch_step(kind))
            return
        for substep in range(kind.substeps):
            self.records.run((kind, substep), lambda at=substep: self._find_contacts(kind, at))
            count = self._visited.choose()
            self.records.run((kind, substep, count), lambda at=substep, count=count: self._visit(kind, at, count))

    def load_kernels(self, progress: Progress | None) -> None:
        """Load what a step launches on CUDA; the states, which it copies to and fro, stay as they are."""
        import warp as wp

        arrays = [getattr(state, name) for state in (self._state, self._next) for name in CHANGING]
        kept = [wp.clone(array) for array in arrays]
        ordinary = StepKind(1.0 / 60.0, 2)
        load_launched_kernels(lambda: self._launch_step(ordinary), self._solver.model.device, progress=progress)
        for array, clone in zip(arrays, kept):
            wp.copy(array, clone)
        self._solver.reset(self._state)

    def _launch_step(self, kind: StepKind) -> None:
        for substep in range(kind.substeps):
            self._find_contacts(kind, substep)
            self._solve(kind, substep)

    def _visit(self, kind: StepKind, substep: int, count: int) -> None:
        assert self._visited is not None
        with self._visited.visiting(count):
            self._solve(kind, substep)

    def _find_contacts(self, kind: StepKind, substep: int) -> None:
        """Find the contacts of a substep, which begins the step if it is the first."""
        before, _ = self._states(substep)
        if substep == 0:
            self._corrections.begin(before)
        if kind.moves_kinematic:
            self._kinematic.place(before, self._corrections.tunneling_guard.teleported, substep, kind.substeps)
            if self._joints is not None:
                self._joints.place(before)
        self._pipeline.collide(before, self._contacts)
        self._corrections.add_contacts(before)

    def _solve(self, kind: StepKind, substep: int) -> None:
        """Move the bodies of a substep whose contacts were found, which ends the step if it is the last."""
        import warp as wp

        before, after = self._states(substep)
        self._corrections.before_solver(kind, substep, before)
        self._solver.whole_step = kind.dt
        self._solver.step(before, after, self._control, self._contacts, kind.substep, observables=self._observables)
        self._corrections.after_solver(kind, substep, before, after, self._observables)
        if substep < kind.substeps - 1:
            return
        if after is not self._state:
            # The next step begins with the same arrays.
            for name in CHANGING:
                wp.copy(getattr(self._state, name), getattr(after, name))
        self._corrections.finish(kind, self._state, self._next)

    def _states(self, substep: int) -> tuple[newton.State, newton.State]:
        """Return the states before and after a substep, which take turns."""
        return (self._next, self._state) if substep % 2 else (self._state, self._next)
