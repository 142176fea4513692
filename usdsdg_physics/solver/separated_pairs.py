"""Spare Newton's narrow phase the pairs of shapes that are apart."""

# Newton declares the arrays of models optional; after `finalize` all are there.
# pyright: reportArgumentType=false, reportOptionalMemberAccess=false

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import newton

THREADS = 64  # each takes a share of the pairs


def drop_separated_pairs(pipeline: newton.CollisionPipeline) -> None:
    """Have a pipeline look at the boxes of shapes in their own axes, between its broad and its narrow phase.

    A third of the pairs of a pile that the broad phase finds are apart in that sense. The others keep their order, and
    so the contacts stay the same to the bit.
    """
    import newton
    import warp as wp

    from usdsdg_physics.solver.separated_pairs_kernels import drop_separated_pairs as kernel

    model: Any = pipeline.model
    names = ("broad_phase_pair_count", "broad_phase_shape_pairs", "geom_transform", "broad_phase")
    if pipeline.device.is_cuda or not all(hasattr(pipeline, name) for name in names):
        return
    kinds = newton.GeoType
    convex = [
        int(kind) for kind in (kinds.BOX, kinds.SPHERE, kinds.CAPSULE, kinds.CYLINDER, kinds.CONE, kinds.CONVEX_MESH)
    ]
    bounded = wp.array(np.isin(model.shape_type.numpy(), convex), dtype=wp.int32, device=pipeline.device)
    broad_phase: Any = pipeline.broad_phase
    find_pairs = broad_phase.launch

    def launch(*args: object, **options: object) -> None:
        find_pairs(*args, **options)
        wp.launch(
            kernel,
            dim=THREADS,
            inputs=[
                bounded,
                model.shape_type,
                model.shape_scale,
                model.shape_source_ptr,
                model.shape_collision_aabb_lower,
                model.shape_collision_aabb_upper,
                model.shape_gap,
                model.shape_margin,
                pipeline.geom_transform,
                pipeline.broad_phase_pair_count,
                THREADS,
            ],
            outputs=[pipeline.broad_phase_shape_pairs],
            device=pipeline.device,
        )

    broad_phase.launch = launch
