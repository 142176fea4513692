"""Embree, through embreex: the benchmark scene as one mesh, its rays one at a time on one thread."""

from __future__ import annotations

import numpy as np

from benchmarks.scene_meshes import FlatMesh


class EmbreeScene:
    """Queries with (N, 3) origins, (N, 3) directions and (N,) reach, all float32."""

    def __init__(self, mesh: FlatMesh) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene as Target

        self._target = Target()
        TriangleMesh(self._target, mesh.points, mesh.triangles)

    def closest(self, origins: np.ndarray, directions: np.ndarray, reach: np.ndarray) -> np.ndarray:
        """(N,) int32 triangle, -1 for none."""
        return self._target.run(origins, directions, dists=reach, query="INTERSECT")

    def occluded(self, origins: np.ndarray, directions: np.ndarray, reach: np.ndarray) -> np.ndarray:
        """(N,) int32, -1 where nothing is met within reach."""
        return self._target.run(origins, directions, dists=reach, query="OCCLUDED")
