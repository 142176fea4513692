"""The contact solver: one step of the velocities and poses of free bodies under forces and contacts."""

# Newton declares the arrays of models and states optional; after `finalize` all are there. Warp structs are no classes.
# pyright: reportOptionalMemberAccess=false, reportArgumentType=false, reportGeneralTypeIssues=false

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp

from usdsdg_physics.contact_solver.arrays import GROUPS, MOST_BURDENED, Bodies, Pairs, Rows
from usdsdg_physics.contact_solver.bodies_kernels import begin_step, end_step, move_bodies
from usdsdg_physics.contact_solver.burden_kernels import find_burdened
from usdsdg_physics.contact_solver.colors_kernels import MAX_ROUNDS, color_pairs
from usdsdg_physics.contact_solver.pairs_kernels import (
    count_colors,
    find_pairs,
    mark_first_rows,
    order_pairs,
    set_keys,
)
from usdsdg_physics.contact_solver.rows_kernels import ask_for_velocities, prepare_rows, report_forces
from usdsdg_physics.contact_solver.sweep_kernels import sweep, sweep_burdened

if TYPE_CHECKING:
    import newton

# Sweeps over all pairs that move bodies, out of each other too, and sweeps after them that correct their velocities.
SWEEPS, VELOCITY_SWEEPS = 32, 8
# Times as many where light bodies carry heavy ones: 150 kg on 1 kg stand.
MORE_SWEEPS = 4
# Steps so short [s] are those of scenes with things of millimeters, of which a stack needs more.
SHORT_STEP = 1.0 / 200.0
SWEEPS_OF_SHORT_STEPS, VELOCITY_SWEEPS_OF_SHORT_STEPS = 96, 32
# Threads of a block of the kernels that wait for each other, bodies for each thread, and how many blocks at most: these
# have to run at the same time.
BLOCK = 64
BODIES_PER_THREAD = 1
MAX_BLOCKS = 64


@dataclass
class Observables:
    """What a step tells besides poses and velocities."""

    contact_f: wp.array | None = None  # (C,) force [N] on the first shape, and a torque that is zero
    body_parent_f: wp.array | None = None  # of joints, which this solver does not have


class ContactSolver:
    """Moves free bodies that touch; it has no joints.

    Contacts are solved pair after pair of bodies, over and over (projected Gauss-Seidel), with the pairs of one color
    at the same time. Sweeps that also push bodies out of each other decide how far bodies move; sweeps after them,
    without that push, at which velocity they go on. Nothing is summed in an order that a GPU would choose, so runs
    repeat bit for bit. The interface is that of Newton's solvers as far as `World` uses it.
    """

    def __init__(
        self,
        model: newton.Model,
        *,
        coordinate: np.ndarray,
        dof: np.ndarray,
        contact_capacity: int,
        penetration_share: float,
    ) -> None:
        """Allocate everything that a step needs.

        Args:
            coordinate: (N,) where each body's pose is in joint_q.
            dof: (N,) where each body's velocity is in joint_qd.
            contact_capacity: most contacts that a step may have.
            penetration_share: part of an overlap that one step removes.
        """
        import newton

        self.model = model
        self._penetration_share = penetration_share
        self.restitution_velocity_threshold = 0.5  # m/s of approach from which contacts bounce
        self.whole_step = 0.0  # s, of which steps of the solver are parts
        device, count, self._capacity = model.device, model.body_count, contact_capacity
        kinematic = (model.body_flags.numpy() & int(newton.BodyFlags.KINEMATIC)) != 0
        moves = ~kinematic & (model.body_inv_mass.numpy() > 0.0)
        self._moves = wp.array(moves.astype(np.int32), device=device)
        self._coordinate = wp.array(coordinate.astype(np.int32), device=device)
        self._dof = wp.array(dof.astype(np.int32), device=device)
        self._bits = (count + 1).bit_length()

        self._bodies = _allocated(Bodies, count + 1, device, overflow_change=(count + 1, 6))
        groups = {"group_size": GROUPS, "group_begin": GROUPS + 1, "group_filled": GROUPS}
        burdened = {"burdened": 1, "burdened_size": GROUPS, "burdened_order": (GROUPS, MOST_BURDENED)}
        self._pairs = _allocated(Pairs, contact_capacity, device, count=1, **groups, **burdened)
        self._rows = _allocated(Rows, contact_capacity, device)
        # The sort needs as much room again.
        self._key = wp.zeros(2 * contact_capacity, dtype=wp.int64, device=device)
        self._contact_of = wp.zeros(2 * contact_capacity, dtype=wp.int32, device=device)
        self._is_first, self._pair_number, self._counter, self._degree, self._still_open = (
            wp.zeros(size, dtype=wp.int32, device=device)
            for size in (contact_capacity, contact_capacity, 1, count + 1, MAX_ROUNDS)
        )
        self._bid = wp.zeros(count + 1, dtype=wp.int64, device=device)
        self._taken = wp.zeros(count + 1, dtype=wp.uint32, device=device)
        # Newton's solvers have it; too many contacts show in the number that the collision pipeline found.
        self.constraint_overflow = wp.zeros(1, dtype=wp.bool, device=device)

        self._threads = self._blocks = 1
        if device.is_cuda:
            blocks = -(-count // (BLOCK * BODIES_PER_THREAD))
            self._blocks = max(1, min(blocks, MAX_BLOCKS, device.sm_count))
            self._threads = BLOCK * self._blocks

    def observables(self, wanted: Collection[str], *, contacts: newton.Contacts) -> Observables:
        """Return what steps fill in when they are given it; `wanted` are names of its fields."""
        if "contact_f" not in wanted:
            return Observables()
        size = contacts.rigid_contact_shape0.size
        return Observables(contact_f=wp.zeros(size, dtype=wp.spatial_vector, device=self.model.device))

    def reset(self, state: newton.State) -> None:
        """Forget earlier steps; nothing is kept of them."""

    def notify_model_changed(self, flags: int) -> None:
        """Hear that the model has changed; each step reads it."""

    def step(
        self,
        before: newton.State,
        after: newton.State,
        control: newton.Control,
        contacts: newton.Contacts,
        dt: float,
        *,
        observables: Observables,
    ) -> None:
        """Move the bodies from the state `before` for `dt` seconds to the state `after`."""
        steel: Any = self.model.steel
        damping = [steel.rigid_body_linear_damping, steel.rigid_body_angular_damping]
        self._begin(before, dt)
        self._sort_contacts(contacts)
        self._prepare_rows(before, contacts, dt)
        sweeps, velocity_sweeps = SWEEPS, VELOCITY_SWEEPS
        if dt < SHORT_STEP:
            sweeps, velocity_sweeps = SWEEPS_OF_SHORT_STEPS, VELOCITY_SWEEPS_OF_SHORT_STEPS
        self._sweep(sweeps)
        self._sweep_burdened(MORE_SWEEPS * sweeps)
        self._launch(
            move_bodies,
            self.model.body_count,
            [self._moves, self._coordinate, self.model.body_com, *damping, self._bodies, before.body_q, dt],
            [after.body_q, after.joint_q],
        )
        self._launch(
            ask_for_velocities, self._capacity, [self._pair_number, self._bodies, self._pairs, dt], [self._rows]
        )
        self._sweep(velocity_sweeps)
        self._launch(
            end_step,
            self.model.body_count,
            [self._moves, self._dof, *damping, self._bodies, dt],
            [after.body_qd, after.joint_qd],
        )
        if observables.contact_f is not None:
            self._report_forces(contacts, observables.contact_f, dt)

    def _begin(self, state: newton.State, dt: float) -> None:
        model = self.model
        self._launch(
            begin_step,
            model.body_count + 1,
            [
                self._moves,
                self._dof,
                model.joint_armature,
                model.body_inv_mass,
                model.body_inertia,
                model.body_inv_inertia,
                model.body_com,
                state.body_q,
                state.body_qd,
                state.body_f,
                model.gravity,
                dt,
            ],
            [self._bodies],
        )

    def _sort_contacts(self, contacts: newton.Contacts) -> None:
        """Sort contacts by the two bodies that touch, and pairs of bodies by color."""
        model, bodies, pairs, bits = self.model, self._bodies, self._pairs, self._bits
        shapes = [contacts.rigid_contact_shape0, contacts.rigid_contact_shape1]
        self._launch(
            set_keys,
            self._capacity,
            [contacts.rigid_contact_count, *shapes, model.shape_body, bodies, model.body_count, bits],
            [self._key, self._contact_of],
        )
        wp.utils.radix_sort_pairs(self._key, self._contact_of, self._capacity, end_bit=2 * bits)
        self._launch(mark_first_rows, self._capacity, [self._key, bits], [self._is_first])
        wp.utils.array_scan(self._is_first, self._pair_number)
        for array in (pairs.group_size, pairs.group_filled, pairs.group_begin):
            array.zero_()
        for array in (self._degree, self._bid, self._taken, self._still_open):
            array.zero_()
        self._launch(
            find_pairs,
            self._capacity,
            [self._key, self._pair_number, bits, bodies, model.body_count],
            [pairs, self._degree],
        )
        self._launch_together(
            color_pairs,
            [bodies, self._degree],
            [self._counter, self._bid, self._taken, self._still_open, pairs],
        )
        self._launch(count_colors, self._capacity, [bodies], [pairs])
        wp.utils.array_scan(pairs.group_size, pairs.group_begin[1:])
        self._launch(order_pairs, self._capacity, [], [pairs])

    def _prepare_rows(self, state: newton.State, contacts: newton.Contacts, dt: float) -> None:
        model = self.model
        names = ("shape0", "shape1", "point0", "point1", "normal", "margin0", "margin1", "surface_velocity")
        self._launch(
            prepare_rows,
            self._capacity,
            [
                self._contact_of,
                self._pair_number,
                *(getattr(contacts, f"rigid_contact_{name}") for name in names),
                model.shape_body,
                model.shape_material_mu,
                model.shape_material_restitution,
                state.body_q,
                state.body_qd,
                model.steel.rigid_body_max_depenetration_velocity,
                self._bodies,
                self._pairs,
                model.body_count,
                self._penetration_share,
                self.restitution_velocity_threshold,
                dt,
                self.whole_step,
            ],
            [self._rows],
        )

    def _sweep(self, iterations: int) -> None:
        self._launch_together(sweep, [iterations], [self._counter, self._bodies, self._pairs, self._rows])

    def _sweep_burdened(self, iterations: int) -> None:
        """Sweep on where light bodies carry heavy ones."""
        for array in (self._bodies.burden, self._pairs.burdened, self._pairs.burdened_size):
            array.zero_()
        self._launch_together(
            find_burdened, [self.model.gravity, self._rows], [self._counter, self._bodies, self._pairs]
        )
        threads = BLOCK if self.model.device.is_cuda else 1
        wp.launch(
            sweep_burdened,
            dim=threads,
            inputs=[threads, iterations],
            outputs=[self._bodies, self._pairs, self._rows],
            block_dim=BLOCK,
            device=self.model.device,
        )

    def _report_forces(self, contacts: newton.Contacts, forces: wp.array, dt: float) -> None:
        forces.zero_()
        self._launch(
            report_forces,
            self._capacity,
            [
                contacts.rigid_contact_shape0,
                self.model.shape_body,
                self._pair_number,
                self._pairs,
                self._rows,
                self.model.body_count,
                dt,
            ],
            [forces],
        )

    def _launch(self, kernel: wp.Kernel, size: int, inputs: list[Any], outputs: list[Any]) -> None:
        wp.launch(kernel, dim=size, inputs=inputs, outputs=outputs, device=self.model.device)

    def _launch_together(self, kernel: wp.Kernel, inputs: list[Any], outputs: list[Any]) -> None:
        """Launch a kernel whose threads wait for each other; they get their number and that of their blocks first."""
        self._counter.zero_()
        wp.launch(
            kernel,
            dim=self._threads,
            inputs=[self._threads, self._blocks, *inputs],
            outputs=outputs,
            block_dim=BLOCK,
            device=self.model.device,
        )


def _allocated(struct: Any, size: int, device: wp.Device, **other_sizes: int | tuple[int, int]) -> Any:
    """Return a Warp struct whose arrays have `size` elements, or their own number of `other_sizes`."""
    instance = struct()
    for name, field in struct.vars.items():
        setattr(instance, name, wp.zeros(other_sizes.get(name, size), dtype=field.type.dtype, device=device))
    return instance
