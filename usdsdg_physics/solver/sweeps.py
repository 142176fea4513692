"""Let Newton's solver sweep over islands of bodies on the CPU, several times as fast and to the same bits."""

# The solver keeps its rows in private arrays, and Warp structs are no classes to a type checker.
# pyright: reportArgumentType=false, reportAttributeAccessIssue=false, reportGeneralTypeIssues=false, reportOptionalMemberAccess=false

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import newton
    import warp as wp

# Fields of `Rows`, and the attributes of the solver that they are.
_ROWS = {
    "count": "_constraint_count",
    "type": "_row_type",
    "parent": "_row_parent",
    "diagonal": "_diag",
    "mu": "_row_mu",
    "jacobian": "_J_world",
    "response": "_Y_world",
    "drive_bias": "_drive_target_vel_bias",
    "drive_velocity_factor": "_drive_vel_multiplier",
    "drive_impulse_factor": "_drive_impulse_multiplier",
    "drive_max_impulse": "_drive_max_impulse",
    "drive_max_velocity": "_drive_vel_limit",
    "free_count": "_mf_constraint_count",
    "free_contact_end": "_mf_contact_rows_end",
    "free_dof_a": "_mf_dof_a",
    "free_dof_b": "_mf_dof_b",
    "free_inverse_diagonal": "_mf_eff_mass_inv",
    "free_type": "_mf_row_type",
    "free_parent": "_mf_row_parent",
    "free_mu": "_mf_row_mu",
    "free_jacobian_a": "_mf_J_a",
    "free_jacobian_b": "_mf_J_b",
    "free_response_a": "_mf_MiJt_a",
    "free_response_b": "_mf_MiJt_b",
}
_OTHERS = (
    "_rhs",
    "_impulses",
    "_mf_impulses",
    "_v_out",
    "_world_dof_indices",
    "_articulation_world_dof_offset",
    "_relaxation",
    "_launch_cpu_mf_gs_phase",
    "_stage4_hinv_jt_par_row",
    "_hinv_jt_writes_world",
    "_local_internal_fast_path",
    "_L_by_size",
    "_J_by_size",
    "_Y_by_size",
    "_group_to_art",
    "_n_arts_by_size",
)


def sweep_by_island(solver: newton.solvers.SolverSteel) -> bool:
    """Replace the solver's sweeps; return whether this version and configuration of it are known."""
    import warp as wp

    known = all(hasattr(solver, name) for name in (*_ROWS.values(), *_OTHERS))
    if not known or solver.model.device.is_cuda or solver._world_dof_indices.shape[0] != 1:
        return False
    if solver._world_dof_indices.size == 0 or getattr(solver, "_double_buffered", False):
        return False
    try:
        sweeps = Sweeps(solver, wp.get_device("cpu"))
    except ImportError:  # another version of Newton has its functions elsewhere
        return False
    solver._launch_cpu_mf_gs_phase = sweeps.launch
    if solver._hinv_jt_writes_world and not solver._local_internal_fast_path:
        solver._stage4_hinv_jt_par_row = sweeps.launch_response
    return True


class Sweeps:
    """The rows of a solver with one world, and room for their units."""

    def __init__(self, solver: Any, device: wp.Device) -> None:
        import warp as wp

        from usdsdg_physics.solver import sweep_arrays
        from usdsdg_physics.solver.sweep_kernels import arrange_rows, solve_rows

        self._solver, self._device = solver, device
        self._arrange_rows, self._solve_rows = arrange_rows, solve_rows
        self._others = solver._launch_cpu_mf_gs_phase
        self._rows = sweep_arrays.Rows()
        for name, attribute in _ROWS.items():
            setattr(self._rows, name, getattr(solver, attribute))
        self._rows.gravity = solver.model.gravity

        dense, free, dofs = self._rows.type.size, self._rows.free_type.size, solver._world_dof_indices.size
        # A dense row may be a drive, a clamp of its speed, and a limit of it.
        units = 3 * dense + free
        starts = np.sort(solver._articulation_world_dof_offset.numpy())
        starts = starts[starts >= 0]
        node = np.searchsorted(starts, np.arange(dofs), side="right") - 1

        def integers(count: int) -> wp.array:
            return wp.zeros(count, dtype=wp.int32, device=device)

        islands = self._islands = sweep_arrays.Islands()
        islands.node = wp.array(node, dtype=wp.int32, device=device)
        islands.dof = solver._world_dof_indices
        islands.velocity = wp.zeros(dofs, dtype=wp.float32, device=device)
        islands.count = integers(1)
        islands.order, islands.active = integers(units), integers(units)
        numbers = sweep_arrays.NUMBERS_PER_FREE_ROW * free + sweep_arrays.HEADER_SIZE * (3 * dense + 1)
        islands.numbers = wp.zeros(numbers, dtype=wp.float32, device=device)
        islands.blocks = wp.zeros(dense, dtype=wp.vec4i, device=device)
        islands.changed, islands.burdened = integers(len(starts)), integers(len(starts))
        islands.found = wp.zeros(units, dtype=wp.vec4i, device=device)
        islands.root, islands.latest = integers(len(starts)), integers(len(starts))
        islands.before, islands.after, islands.step = integers(units), integers(units), integers(units)
        islands.begin = integers(sweep_arrays.KINDS * units + 1)

    def launch(
        self,
        row_phase: int,
        iterations: int,
        *,
        rhs: wp.array,
        regularize: bool,
        freeze_drive_rows: bool,
        friction_start_iteration: int,
        iteration_offset: int,
    ) -> None:
        """Take the place of the solver's method of the same arguments."""
        import warp as wp

        solver = self._solver
        if row_phase or regularize or friction_start_iteration:
            self._others(
                row_phase,
                iterations,
                rhs=rhs,
                regularize=regularize,
                freeze_drive_rows=freeze_drive_rows,
                friction_start_iteration=friction_start_iteration,
                iteration_offset=iteration_offset,
            )
            return
        if rhs is solver._rhs:
            # The velocity sweeps that follow have other right-hand sides and the same rows.
            clamps = int(solver._velocity_limits_fused)
            wp.launch(
                self._arrange_rows, dim=1, inputs=[self._rows, clamps], outputs=[self._islands], device=self._device
            )
        wp.launch(
            self._solve_rows,
            dim=1,
            inputs=[
                self._rows,
                self._islands,
                rhs,
                solver._cpu_mf_meta_rhs,
                iterations,
                solver._relaxation,
                int(freeze_drive_rows),
            ],
            outputs=[solver._impulses, solver._mf_impulses, solver._v_out],
            device=self._device,
        )

    def launch_response(self, size: int) -> None:
        """Take the place of the solver's method of the same argument, the number of dofs of some articulations."""
        import warp as wp

        from usdsdg_physics.solver.response_kernels import respond_to_rows

        solver = self._solver
        wp.launch(
            respond_to_rows,
            dim=solver._n_arts_by_size[size],
            inputs=[
                solver._L_by_size[size],
                solver._J_by_size[size],
                solver._group_to_art[size],
                solver._articulation_world_dof_offset,
                solver._constraint_count,
            ],
            outputs=[solver._Y_by_size[size], solver._J_world, solver._Y_world],
            device=self._device,
        )
