"""BVH construction over boxes, by `build_tree.cpp`."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportGeneralTypeIssues=false, reportInvalidTypeForm=false, reportOptionalMemberAccess=false

from pathlib import Path

import numpy as np
import warp as wp

from usdsdg.errors import RenderError
from usdsdg_render.memory.staging_buffer import aligned, shared

NODE_WORDS = 64


@wp.struct
class Task:
    """Inputs and outputs of `build_tree.cpp`, described there."""

    lowers: wp.array2d(dtype=wp.float32)
    uppers: wp.array2d(dtype=wp.float32)
    block: wp.int32
    leaf_limit: wp.int32
    max_depth: wp.int32
    order: wp.array(dtype=wp.int32)
    count: wp.int32  # of `order`
    # out
    nodes: wp.array2d(dtype=wp.float32)
    members: wp.array2d(dtype=wp.int32)
    counts: wp.array(dtype=wp.int32)


@wp.func_native(Path(__file__).with_name("build_tree.cpp").read_text())
def build_tree_of(task: Task): ...


@wp.kernel(enable_backward=False)
def build_tree(task: Task):
    build_tree_of(task)


class Builder:
    """Builds BVHs over boxes in fixed memory; call `build` again after the boxes changed.

    Args:
        lower, upper: (N, 3) float32 corners of boxes.
        count: number of boxes in the tree, > 0.
        block: boxes that are tested at once.
        leaf: maximum number of boxes in a leaf.
        max_depth: maximum number of levels of nodes.
        nodes: (count, NODE_WORDS) float32 output, aligned to cache lines; None allocates it.

    Attributes:
        order: (count,) int32 indices of the boxes to use; `build` permutes it to leaf order.
        nodes: the nodes, in the format of `build_tree.cpp`.
        members: (count, block) int32: boxes of each block, -1 in empty lanes; empty if a block is one box.
        depth: number of levels of nodes.
    """

    def __init__(
        self,
        lower: np.ndarray,
        upper: np.ndarray,
        count: int,
        *,
        block: int = 1,
        leaf: int = 1,
        max_depth: int,
        nodes: np.ndarray | None = None,
    ) -> None:
        if 8**max_depth < count:
            raise RenderError(f"{count} objects do not fit a tree {max_depth} levels deep. Split the scene.")
        self.block = block
        self.depth = 0
        self.order = np.arange(count, dtype=np.int32)
        # An inner node has at least two children, so there are fewer nodes than boxes.
        self.nodes = aligned((count, NODE_WORDS), np.float32) if nodes is None else nodes
        self.members = np.empty((count if block > 1 else 0, block), np.int32)
        self._max_depth = max_depth
        self._counts = np.zeros(3, np.int32)
        task = Task()
        task.lowers, task.uppers = shared(lower, wp.float32), shared(upper, wp.float32)
        task.block, task.leaf_limit, task.max_depth = block, leaf, max_depth
        task.nodes, task.count = shared(self.nodes, wp.float32), count
        task.order, task.members, task.counts = (
            shared(each, wp.int32) for each in (self.order, self.members, self._counts)
        )
        self._launch = wp.launch(build_tree, dim=1, inputs=[task], device="cpu", record_cmd=True)

    def build(self) -> tuple[int, int]:
        """Fill `nodes` and `members`; return the numbers of nodes and blocks."""
        self._launch.launch()
        nodes, blocks, self.depth = self._counts.tolist()
        if self.depth > self._max_depth:
            raise RenderError(
                f"a tree over {len(self.order)} boxes is {self.depth} levels deep, more than {self._max_depth}: are "
                f"they finite?"
            )
        return nodes, blocks
