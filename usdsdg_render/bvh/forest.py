"""Many top-level acceleration structures (TLAS), one for each world, built together."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportGeneralTypeIssues=false, reportInvalidTypeForm=false, reportOptionalMemberAccess=false
# pyright: reportOperatorIssue=false

from typing import Any

import numpy as np
import warp as wp

from usdsdg.parallel import launch_rows
from usdsdg_render.bvh.acceleration_structure import tlas_node_dtype
from usdsdg_render.bvh.build import NODE_WORDS, Task, build_tree_of
from usdsdg_render.bvh.compress import NODE_WORDS as COMPRESSED_WORDS
from usdsdg_render.bvh.compress import Compression, compress_tree_of
from usdsdg_render.bvh.query import MAX_TLAS_DEPTH
from usdsdg_render.memory.staging_buffer import shared

_NODE_BYTES = wp.constant(4 * NODE_WORDS)
_COMPRESSED_BYTES = wp.constant(4 * COMPRESSED_WORDS)
_COUNT_WORDS = wp.constant(3)
# Trees that a thread builds at a time, at least.
TREES_AT_ONCE = 4


@wp.struct
class Forest:
    """Inputs and outputs of `build_forest`. Tree w is over boxes of the rows [w * size, (w + 1) * size)."""

    lowers: wp.array2d(dtype=wp.float32)
    uppers: wp.array2d(dtype=wp.float32)
    size: wp.int32  # rows of a tree; nodes too, of which there are fewer
    max_depth: wp.int32
    chosen: wp.uint64  # address of int32: in each range of rows first the rows of the tree, which are permuted
    counts: wp.array(dtype=wp.int32)  # rows of each tree
    nodes: wp.uint64  # address of the nodes of build_tree.cpp, `size` for each tree
    built: wp.uint64  # address of three int32 for each tree: nodes, blocks, depth
    # Of trees for CUDA:
    write_order: wp.uint64  # address of int32, `size` for each tree
    compressed: wp.uint64  # address of the nodes of compress.py; 0 = not compressed
    order: wp.array(dtype=wp.int32)  # rows in leaf order, those of tree w in its range


@wp.kernel(enable_backward=False)
def build_forest(forest: Forest, first: int):
    w = wp.tid() + first
    count = forest.counts[w]
    if count == 0:
        return
    row = wp.uint64(w * forest.size)
    nodes = wp.array(ptr=forest.nodes + row * wp.uint64(_NODE_BYTES), shape=(forest.size, NODE_WORDS), dtype=wp.float32)
    built = wp.array(ptr=forest.built + wp.uint64(4 * _COUNT_WORDS * w), shape=(_COUNT_WORDS,), dtype=wp.int32)
    task = Task()
    task.lowers = forest.lowers
    task.uppers = forest.uppers
    task.block = 1
    task.leaf_limit = 1
    task.max_depth = forest.max_depth
    task.order = wp.array(ptr=forest.chosen + row * wp.uint64(4), shape=(count,), dtype=wp.int32)
    task.count = count
    task.nodes = nodes
    task.counts = built
    build_tree_of(task)
    if forest.compressed == wp.uint64(0):
        return
    compression = Compression()
    compression.nodes = nodes
    compression.block = 1
    compression.first_item = w * forest.size
    compression.write_order = wp.array(
        ptr=forest.write_order + row * wp.uint64(4), shape=(forest.size,), dtype=wp.int32
    )
    compression.compressed = wp.array(
        ptr=forest.compressed + row * wp.uint64(_COMPRESSED_BYTES),
        shape=(forest.size, COMPRESSED_WORDS),
        dtype=wp.uint32,
    )
    compression.order = forest.order
    compression.counts = built
    compress_tree_of(compression)


class ForestBuilder:
    """Builds a TLAS for each of `trees` ranges of `size` instances, on the CPU for any device.

    Attributes:
        lower, upper: (trees * size, 3) float32 corners of world boxes.
    """

    def __init__(self, trees: int, size: int, device: str) -> None:
        self.lower, self.upper = np.zeros((2, trees * size, 3), np.float32)
        self._trees, self._size, self._on_cpu = trees, size, device == "cpu"
        self._chosen = np.zeros((trees, size), np.int32)
        self._counts = np.zeros(trees, np.int32)
        self._built = np.zeros((trees, 3), np.int32)
        # What the CPU traverses it builds in place.
        self._scratch = None if self._on_cpu else np.empty((trees * size, NODE_WORDS), np.float32)
        self._write_order = np.empty(0 if self._on_cpu else trees * size, np.int32)
        self._rows = np.arange(trees * size, dtype=np.int32).reshape(trees, size)

    @property
    def node_bytes(self) -> int:
        """Bytes of the nodes of one tree."""
        return self._size * tlas_node_dtype("cpu" if self._on_cpu else "cuda").itemsize

    def build(self, placed: np.ndarray, nodes: np.ndarray, order: np.ndarray) -> np.ndarray:
        """Build the trees over some of the instances; return (trees,) int32, how many are in each.

        Args:
            placed: (trees, size) bool, those that rays can hit.
            nodes: (trees * size, …) of `tlas_node_dtype`, output.
            order: (trees * size,) int32, output: instances in leaf order (CUDA only).
        """
        if placed.all():
            self._chosen[:] = self._rows
            self._counts[:] = self._size
        else:
            first = np.argsort(~placed, axis=1, kind="stable")
            self._chosen[:] = np.take_along_axis(self._rows, first, 1)
            self._counts[:] = placed.sum(1)
        forest: Any = Forest()
        forest.lowers, forest.uppers = shared(self.lower, wp.float32), shared(self.upper, wp.float32)
        forest.size, forest.max_depth = self._size, MAX_TLAS_DEPTH
        forest.chosen, forest.counts = self._chosen.ctypes.data, shared(self._counts, wp.int32)
        forest.nodes = (nodes if self._scratch is None else self._scratch).ctypes.data
        forest.built = self._built.ctypes.data
        if self._scratch is not None:
            forest.write_order, forest.compressed = self._write_order.ctypes.data, nodes.ctypes.data
            forest.order = shared(order, wp.int32)
        launch_rows(build_forest, (self._trees,), [forest], [], device="cpu", band_rows=TREES_AT_ONCE)
        return self._counts
