"""Bottom-level and top-level acceleration structures (BLAS, TLAS): eight-wide BVHs, compressed on CUDA."""

import numpy as np
import warp as wp

from usdsdg_render.bvh import build, compress
from usdsdg_render.bvh.build import Builder
from usdsdg_render.bvh.compress import LEAF_ITEMS, Compressor
from usdsdg_render.bvh.query import MAX_BLAS_DEPTH, MAX_TLAS_DEPTH
from usdsdg_render.memory.staging_buffer import aligned, shared

LANES = 8
LEAF_TRIANGLES = 16  # two blocks: measured faster than one, with half the nodes
_BLOCK_WORDS = 80


class Blas:
    """BVH over the triangles of a prototype: addresses of its `nodes` and of its triangles (`blocks`)."""

    def __init__(self, points: np.ndarray, triangles: np.ndarray, device: str) -> None:
        if device == "cpu":
            self._memory = [shared(each, wp.float32) for each in cpu_blas(points, triangles)]
        else:
            nodes, corners = cuda_blas(points, triangles)
            self._memory = [
                wp.array(nodes, dtype=wp.uint32, device=device),
                wp.array(corners, dtype=wp.float32, device=device),
            ]
        self.nodes, self.blocks = (int(each.ptr) for each in self._memory)


def cpu_blas(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Build the BLAS of a prototype for a CPU, from (V, 3) float32 points and (T, 3) int32 triangles, T > 0.

    Returns:
        (N, NODE_WORDS) float32 nodes, and (B, 80) float32 blocks: rows of eight x, y, z of three corners, then eight
        triangle indices. Both are aligned to cache lines.
    """
    corners = points[triangles]
    builder = _blas_builder(corners, block=LANES, leaf=LEAF_TRIANGLES)
    node_count, block_count = builder.build()
    nodes = aligned((node_count, build.NODE_WORDS), np.float32)
    nodes[:] = builder.nodes[:node_count]
    members = builder.members[:block_count]
    blocks = aligned((block_count, _BLOCK_WORDS), np.float32)
    # Empty lanes hold a triangle of zeros, which the intersection test rejects.
    lanes = np.where(members[:, :, None, None] >= 0, corners[members], np.float32(0))
    blocks[:, :72] = lanes.transpose(0, 2, 3, 1).reshape(block_count, 72)
    blocks[:, 72:].view(np.int32)[:] = members
    return nodes, blocks


def cuda_blas(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Build the BLAS of a prototype for CUDA.

    Returns:
        (N, compress.NODE_WORDS) uint32 nodes, and (T, 3, 4) float32 corners in leaf order; the fourth component
        of the first corner holds the bits of the triangle's index.
    """
    corners = points[triangles]
    builder = _blas_builder(corners, block=LEAF_ITEMS, leaf=LEAF_ITEMS)
    node_count, _ = builder.build()
    nodes = np.empty((node_count, compress.NODE_WORDS), np.uint32)
    order = np.empty(len(triangles), np.int32)
    Compressor(builder, nodes, order).compress()
    rows = np.zeros((len(order), 3, 4), np.float32)
    rows[..., :3] = corners[order]
    rows[:, 0, 3] = order.view(np.float32)
    return nodes, rows


def _blas_builder(corners: np.ndarray, *, block: int, leaf: int) -> Builder:
    lower, upper = corners.min(1), corners.max(1)
    return Builder(lower, upper, len(corners), block=block, leaf=leaf, max_depth=MAX_BLAS_DEPTH)


def tlas_node_dtype(device: str) -> np.dtype:
    """Return the dtype of a TLAS node on a device."""
    return np.dtype((np.float32, build.NODE_WORDS)) if device == "cpu" else np.dtype((np.uint32, compress.NODE_WORDS))


class TlasBuilder:
    """Builds the TLAS over instance bounds, in memory that is given once.

    Args:
        lower, upper: (N, 3) float32 corners of world bounds.
        nodes: (N, …) output, of `tlas_node_dtype`.
        order: (N,) int32 output, the instances in leaf order (CUDA only).
    """

    def __init__(self, lower: np.ndarray, upper: np.ndarray, nodes: np.ndarray, order: np.ndarray, device: str) -> None:
        self._boxes = lower, upper
        self._nodes, self._order = nodes, order
        self._on_cpu = device == "cpu"
        self._count = 0

    def build(self, instances: np.ndarray) -> int:
        """Build over the instances with these row numbers, one or more; return the number of nodes."""
        if len(instances) != self._count:
            self._count = len(instances)
            nodes = self._nodes[: self._count] if self._on_cpu else None
            self._builder = Builder(*self._boxes, self._count, max_depth=MAX_TLAS_DEPTH, nodes=nodes)
            self._compressor = None if self._on_cpu else Compressor(self._builder, self._nodes, self._order)
        self._builder.order[:] = instances
        count, _ = self._builder.build()
        if self._compressor is not None:
            self._compressor.compress()
        return count
