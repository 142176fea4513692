"""Launch the overlap kernel over all colliders of a scene, with arguments that are packed once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import warp as wp

from usdsdg_physics.queries.overlap_kernels import overlaps
from usdsdg_physics.scene.records import SHAPE_KINDS, ShapeKind


class OverlapLaunch:
    """The kernel with its arrays: packing its fifteen arguments anew would take longer than to run it."""

    def __init__(
        self,
        enabled: np.ndarray,
        bodies: np.ndarray,
        frames: np.ndarray,
        bounds: np.ndarray,
        tables: Sequence[wp.array],
    ) -> None:
        """Use the given arrays; what the caller changes in them later, each launch sees.

        Args:
            enabled: (N,) bool.
            bodies: (N,) int32, row of each collider's body, -1 for none.
            frames: (N, 7) float64, in the body's frame or the world.
            bounds: (N, 4) float64, center and radius of a sphere around each shape.
            tables: kinds, sizes, first points, point counts and points of the shapes.
        """
        self._poses = wp.zeros(int(bodies.max()) + 1, dtype=wp.transformd, device="cpu")
        self._hit = wp.zeros(len(bodies), dtype=wp.int32, device="cpu")
        self._poses_view, self._hit_view = self._poses.numpy().reshape(-1, 7), self._hit.numpy()
        shared = [
            wp.array(array, dtype=dtype, device="cpu", copy=False)
            for array, dtype in (
                (enabled, wp.bool),
                (bodies, wp.int32),
                (frames, wp.transformd),
                (bounds, wp.vec4d),
            )
        ]
        launch = wp.launch(
            overlaps,
            dim=len(bodies),
            inputs=[*shared, *tables, self._poses, 0, wp.vec3d(), wp.transformd()],
            outputs=[self._hit],
            device="cpu",
            record_cmd=True,
        )
        assert isinstance(launch, wp.Launch)
        self._launch = launch

    def hits(self, poses: np.ndarray, kind: ShapeKind, size: np.ndarray, origin: np.ndarray, rotation: np.ndarray):
        """Return (N,) int32: 1 for the colliders that overlap a box or sphere, valid until the next call.

        Args:
            poses: (M, 7) of the bodies.
            rotation: unit quaternion x, y, z, w.
        """
        self._poses_view[:] = poses[: len(self._poses_view)]
        self._launch.set_param_by_name("query_kind", SHAPE_KINDS.index(kind))
        self._launch.set_param_by_name("query_size", wp.vec3d(*size.tolist()))
        frame = wp.transformd(wp.vec3d(*origin.tolist()), wp.quatd(*rotation.tolist()))
        self._launch.set_param_by_name("query_frame", frame)
        self._launch.launch()
        return self._hit_view
