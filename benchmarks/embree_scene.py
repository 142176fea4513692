"""The benchmark scene in Embree, through embreex: one mesh, single rays, one thread."""

from __future__ import annotations

import numpy as np

from benchmarks.scene_meshes import FlatMesh


class EmbreeScene:
    """Ray queries with (N, 3) origins, (N, 3) directions and (N,) maximum distances, all float32."""

    def __init__(self, mesh: FlatMesh) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene as Target

        self._target = Target()
        TriangleMesh(self._target, mesh.points, mesh.triangles)

    def closest(self, origins: np.ndarray, directions: np.ndarray, max_distance: np.ndarray) -> np.ndarray:
        """Return the closest triangles (N,) int32, -1 for none."""
        return self._target.run(origins, directions, dists=max_distance, query="INTERSECT")

    def occluded(self, origins: np.ndarray, directions: np.ndarray, max_distance: np.ndarray) -> np.ndarray:
        """Return (N,) int32, -1 where nothing is hit within the maximum distance."""
        return self._target.run(origins, directions, dists=max_distance, query="OCCLUDED")
