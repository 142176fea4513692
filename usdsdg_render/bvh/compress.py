"""Compression of BVHs for CUDA: 80-byte nodes with child boxes quantized to 8 bits.

A node is five rows of four words, as `compressed.cpp` reads them:

    corner x, y, z; step exponents in x, y, z, and in the last byte a bit for each child that is a node
    index of the first child node, and of the first item; eight bytes, one for each child
    eight bytes each of lower x, lower y, lower z, upper x, upper y, upper z

A child's byte is 0 if empty, 32 + 24 + slot for a node, and for a leaf three bits with a one for each of its items,
above five bits with the offset of the first. Children are assigned to slots by their octant relative to the center of
the node, so that the slot number alone, compared with the signs of a ray, orders them from near to far.
"""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportGeneralTypeIssues=false, reportInvalidTypeForm=false, reportOptionalMemberAccess=false

from pathlib import Path

import numpy as np
import warp as wp

from usdsdg_render.bvh.build import Builder
from usdsdg_render.memory.staging_buffer import shared

LEAF_ITEMS = 2  # on an H200 8 % faster than three
NODE_WORDS = 20


@wp.struct
class Compression:
    """Inputs and outputs of `compress_tree.cpp`, described there."""

    nodes: wp.array2d(dtype=wp.float32)
    members: wp.array2d(dtype=wp.int32)
    block: wp.int32
    first_item: wp.int32  # index in `order` of the tree's items
    # out
    write_order: wp.array(dtype=wp.int32)
    compressed: wp.array2d(dtype=wp.uint32)
    order: wp.array(dtype=wp.int32)
    counts: wp.array(dtype=wp.int32)


@wp.func_native(Path(__file__).with_name("compress_tree.cpp").read_text())
def compress_tree_of(task: Compression): ...


@wp.kernel(enable_backward=False)
def compress_tree(task: Compression):
    compress_tree_of(task)


class Compressor:
    """Compresses the tree of a builder; call `compress` again after each build.

    Args:
        nodes: (N, NODE_WORDS) uint32 output.
        order: (M,) int32 output: the items (triangles or instances) in leaf order.
    """

    def __init__(self, builder: Builder, nodes: np.ndarray, order: np.ndarray) -> None:
        self._counts = np.zeros(2, np.int32)
        task = Compression()
        task.nodes, task.members = shared(builder.nodes, wp.float32), shared(builder.members, wp.int32)
        task.block = builder.block
        task.write_order = wp.empty(len(builder.nodes), dtype=wp.int32, device="cpu")
        task.compressed, task.order = shared(nodes, wp.uint32), shared(order, wp.int32)
        task.counts = shared(self._counts, wp.int32)
        self._launch = wp.launch(compress_tree, dim=1, inputs=[task], device="cpu", record_cmd=True)

    def compress(self) -> int:
        """Fill `nodes` and `order`; return the number of nodes."""
        self._launch.launch()
        return int(self._counts[0])
