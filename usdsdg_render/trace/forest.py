"""The trees of a scene in the memory of the device that traces them."""

from __future__ import annotations

import numpy as np
import warp as wp

from usdsdg_render.trace import build


class BottomTree:
    """The tree over the triangles of a prototype: addresses of its `nodes` and of its triangles (`blocks`)."""

    def __init__(self, points: np.ndarray, triangles: np.ndarray, device: str) -> None:
        if device == "cpu":
            tree = build.build_bottom(points, triangles)
            self._held = [_shared(tree.nodes), _shared(tree.blocks)]
        else:
            compressed, corners = build.compress_bottom(points, triangles)
            self._held = [_uploaded(compressed.nodes, device), _uploaded(corners, device)]
        self.nodes, self.blocks = (int(each.ptr) for each in self._held)


class TopTree:
    """The tree over the boxes of instances: the address of its `nodes`, and on CUDA the instances in its `order`."""

    def __init__(self, lower: np.ndarray, upper: np.ndarray, instances: np.ndarray, device: str) -> None:
        if device == "cpu":
            self._held = _shared(build.build_top(lower, upper, instances).nodes)
            self.order = wp.empty(0, dtype=wp.int32, device=device)
        else:
            compressed = build.compress_top(lower, upper, instances)
            self._held = _uploaded(compressed.nodes, device)
            self.order = wp.array(compressed.order, dtype=wp.int32, device=device)
        self.nodes = int(self._held.ptr)


def _shared(values: np.ndarray) -> wp.array:
    """The array itself, where it lies."""
    return wp.array(values.reshape(-1), dtype=wp.float32, device="cpu", copy=False)


def _uploaded(values: np.ndarray, device: str) -> wp.array:
    return wp.array(values.reshape(-1).view(np.uint32), dtype=wp.uint32, device=device)
