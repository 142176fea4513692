"""Trees to trace: one per prototype over its triangles, one over the boxes of all instances.

A CPU reads them as they are built; CUDA reads them compressed.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import warp as wp

from usdsdg.errors import RenderError
from usdsdg_render.trace.compress import LEAF_ITEMS, CompressedTree, compress
from usdsdg_render.trace.query import MAX_BOTTOM_DEPTH, MAX_TOP_DEPTH

LANES = 8
LEAF_TRIANGLES = 16  # two blocks: measured faster than one, and half the nodes
_NODE_WORDS = 64
_BLOCK_WORDS = 80
_LINE = 64  # bytes; vector loads of nodes and blocks assume this alignment


@wp.struct
class Task:
    """What `build_tree.cpp` reads and fills; boxes are three numbers each in `lowers` and `uppers`."""

    lowers: wp.array(dtype=wp.float32)
    uppers: wp.array(dtype=wp.float32)
    block: wp.int32
    leaf_limit: wp.int32
    max_depth: wp.int32
    # out
    order: wp.array(dtype=wp.int32)
    nodes: wp.array(dtype=wp.float32)
    members: wp.array(dtype=wp.int32)
    counts: wp.array(dtype=wp.int32)


@wp.func_native(Path(__file__).with_name("build_tree.cpp").read_text())
def _build_tree(task: Task): ...


@wp.kernel(enable_backward=False)
def build_tree(task: Task):
    _build_tree(task)


@dataclass(frozen=True)
class BottomTree:
    """The tree over one prototype."""

    nodes: np.ndarray  # (N, 64) float32, lines of memory aligned
    blocks: np.ndarray  # (B, 80) float32: rows of eight x, y, z of three corners, then eight triangle indices
    depth: int


@dataclass(frozen=True)
class TopTree:
    """The tree over all instances."""

    nodes: np.ndarray  # (N, 64) float32
    depth: int


def build_bottom(points: np.ndarray, triangles: np.ndarray) -> BottomTree:
    """Build the tree of a prototype from (V, 3) float32 points and (T, 3) int32 triangles, T > 0."""
    corners = points[triangles]
    lower, upper = corners.min(1), corners.max(1)
    nodes, members, depth = _build(lower, upper, LANES, LEAF_TRIANGLES, MAX_BOTTOM_DEPTH)
    blocks = aligned((len(members), _BLOCK_WORDS), np.float32)
    # Empty lanes hold the triangle 0 0 0, which the intersection test rejects.
    lanes = np.where(members[:, :, None, None] >= 0, corners[members], np.float32(0))
    blocks[:, :72] = lanes.transpose(0, 2, 3, 1).reshape(len(members), 72)
    blocks[:, 72:].view(np.int32)[:] = members
    return BottomTree(nodes, blocks, depth)


def build_top(lower: np.ndarray, upper: np.ndarray, instances: np.ndarray) -> TopTree:
    """Build the tree over boxes, (I, 3) float32 each, I > 0, of the instances with these row numbers."""
    nodes, _, depth = _build(lower, upper, 1, 1, MAX_TOP_DEPTH)
    children = nodes[:, 48:56].view(np.int32)
    children[children < 0] = ~instances[~children[children < 0]]
    return TopTree(nodes, depth)


def compress_bottom(points: np.ndarray, triangles: np.ndarray) -> tuple[CompressedTree, np.ndarray]:
    """As `build_bottom` for CUDA, and (T, 3, 4) float32 corners in the tree's order, the first with its triangle."""
    corners = points[triangles]
    nodes, members, _ = _build(corners.min(1), corners.max(1), LEAF_ITEMS, LEAF_ITEMS, MAX_BOTTOM_DEPTH)
    children = nodes[:, 48:56].view(np.int32)
    children[children < 0] >>= 2  # a leaf is one block
    tree = compress(*_boxes(nodes), children, members)
    rows = np.zeros((len(tree.order), 3, 4), np.float32)
    rows[..., :3] = corners[tree.order]
    rows[:, 0, 3] = tree.order.view(np.float32)
    return tree, rows


def compress_top(lower: np.ndarray, upper: np.ndarray, instances: np.ndarray) -> CompressedTree:
    """As `build_top` for CUDA."""
    nodes, _, _ = _build(lower, upper, 1, 1, MAX_TOP_DEPTH)
    members = np.full((len(instances), LEAF_ITEMS), -1, np.int32)
    members[:, 0] = instances
    return compress(*_boxes(nodes), nodes[:, 48:56].view(np.int32), members)


def _boxes(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corners of the children, (N, 8, 3) each."""
    boxes = nodes[:, :48].reshape(-1, 2, 3, LANES).transpose(1, 0, 3, 2)
    return boxes[0], boxes[1]


def _build(lower: np.ndarray, upper: np.ndarray, block: int, leaf: int, max_depth: int):
    n = len(lower)
    if 8**max_depth < n:
        raise RenderError(f"{n} objects do not fit a tree {max_depth} levels deep. Split the scene.")
    # An inner node has at least two children, so there are fewer of them than boxes.
    nodes = np.empty((max(1, n), _NODE_WORDS), np.float32)
    members = np.empty((max(1, n) if block > 1 else 0, block), np.int32)
    order, counts = np.empty(n, np.int32), np.zeros(3, np.int32)
    task = Task()
    task.lowers, task.uppers = _shared(lower), _shared(upper)
    task.block, task.leaf_limit, task.max_depth = block, leaf, max_depth
    task.order, task.nodes, task.members, task.counts = map(_shared, (order, nodes, members, counts))
    wp.launch(build_tree, dim=1, inputs=[task], device="cpu")
    node_count, block_count, depth = counts.tolist()
    if depth > max_depth:
        raise RenderError(f"a tree over {n} boxes is {depth} levels deep, more than {max_depth}: are they finite?")
    packed = aligned((node_count, _NODE_WORDS), np.float32)
    packed[:] = nodes[:node_count]
    return packed, members[:block_count], depth


def _shared(values: np.ndarray) -> wp.array:
    """A flat Warp view of a contiguous NumPy array, without a copy."""
    flat = np.ascontiguousarray(values).reshape(-1)
    dtype = wp.int32 if flat.dtype == np.int32 else wp.float32
    return wp.array(flat, dtype=dtype, device="cpu", copy=False)


def aligned(shape: tuple[int, ...], dtype) -> np.ndarray:
    """An uninitialised array whose first element starts a cache line."""
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    raw = np.empty(size + _LINE, np.uint8)
    start = -raw.ctypes.data % _LINE
    return raw[start : start + size].view(dtype).reshape(shape)
