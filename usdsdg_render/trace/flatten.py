"""The CUDA back end's structure: one `wp.Mesh` of all triangles in the world, built anew whenever something moved.

On a GPU this is faster to trace than two levels, and building takes milliseconds.
"""

from __future__ import annotations

import numpy as np
import warp as wp

from usdsdg_render.kernels import types
from usdsdg_render.kernels.flatten import place_triangles


class FlattenedMesh:
    """One mesh of some instances; `first_face` of their rows says where each begins."""

    def __init__(self, device: str) -> None:
        self.device = device
        self.mesh: wp.Mesh | None = None
        self.face_instance = wp.empty(0, dtype=wp.int32, device=device)

    @property
    def id(self) -> int:
        """Handle for kernels; 0 = nothing to hit."""
        return int(self.mesh.id) if self.mesh is not None else 0

    def place(self, rows: np.ndarray, face_counts: np.ndarray) -> None:
        """Build the mesh of the instances with faces.

        Args:
            rows: records of all instances (`types.Instance`); `first_face` is written.
            face_counts: (I,) triangles of each instance that belong in the mesh.
        """
        self.mesh = None
        rows["first_face"] = np.cumsum(face_counts) - face_counts
        total = int(face_counts.sum())
        if total == 0:
            return
        owners = np.repeat(np.arange(len(rows), dtype=np.int32), face_counts)
        self.face_instance = wp.array(owners, dtype=wp.int32, device=self.device)
        points = wp.empty(3 * total, dtype=wp.vec3, device=self.device)
        instances = wp.array(rows, dtype=types.Instance, device=self.device)
        wp.launch(
            place_triangles,
            dim=total,
            inputs=[instances, self.face_instance],
            outputs=[points],
            device=self.device,
        )
        indices = wp.array(np.arange(3 * total, dtype=np.int32), dtype=wp.int32, device=self.device)
        self.mesh = wp.Mesh(points, indices)
