"""Rebounds that begin at the surface, and are as high as restitution says."""

# The solver keeps its rows in private arrays, and Newton declares the arrays of models optional.
# pyright: reportAttributeAccessIssue=false, reportOptionalMemberAccess=false

from __future__ import annotations

from typing import Any

# What `land_first` takes of the rows of free bodies, and sets.
_ROWS = (
    "_mf_constraint_count",
    "_mf_row_type",
    "_mf_phi",
    "_mf_target_velocity",
    "_mf_dof_a",
    "_mf_dof_b",
    "_mf_J_a",
    "_mf_J_b",
    "_world_dof_indices",
)
_OTHERS = ("_v_hat", "_mf_row_rebound_velocity", "_mf_rhs", "_pack_mf_meta", "_solve_matrix_free")


def rebound_at_surfaces(solver: Any) -> None:
    """Let free bodies reach the surface in the substep in which they bounce, if the materials of a model bounce.

    The solver turns them around where they are at its begin, up to a contact gap or a substep's way too high: a ball
    with restitution 0.1 that fell a meter rose to 2.7 cm, not 1 cm. As in PhysX, the sweeps that move bodies let them
    touch here; those for velocities, which come after, ask for the rebound.

    The solver has to be told the `whole_step` [s] of which its step is a part.
    """
    restitution = solver.model.shape_material_restitution
    known = all(hasattr(solver, name) for name in (*_ROWS, *_OTHERS)) and solver._world_dof_indices.shape[0] == 1
    if not known or solver.model.shape_count == 0 or not (restitution.numpy() > 0.0).any():
        return
    prepare_sweeps, solve = solver._pack_mf_meta, solver._solve_matrix_free
    before, substep = None, 0.0

    def solve_substep(state: Any, augmented: Any, contacts: Any, dt: float) -> None:
        nonlocal before, substep
        before, substep = state, dt
        solve(state, augmented, contacts, dt)

    def land_and_prepare(right_side: Any) -> None:
        if right_side is solver._mf_rhs:  # of the sweeps that move bodies
            _land_first(solver, before, substep)
        prepare_sweeps(right_side)

    solver._solve_matrix_free, solver._pack_mf_meta = solve_substep, land_and_prepare


def _land_first(solver: Any, before: Any, dt: float) -> None:
    import warp as wp

    from usdsdg_physics.solver.rebounds_kernels import land_first

    rows = [getattr(solver, name) for name in _ROWS]
    wp.launch(
        land_first,
        dim=solver._mf_rhs.shape[1],
        inputs=[*rows, before.joint_qd, solver._v_hat, dt, solver.whole_step],
        outputs=[solver._mf_row_rebound_velocity, solver._mf_rhs],
        device=solver.model.device,
    )
