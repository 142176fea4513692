"""Trees that are built together are those that are built one by one."""

import numpy as np
import pytest

from usdsdg_render.bvh.acceleration_structure import TlasBuilder, tlas_node_dtype
from usdsdg_render.bvh.forest import ForestBuilder

TREES, SIZE = 5, 23


@pytest.mark.parametrize("device", ["cpu", "cuda:0"])  # nodes for CUDA are built on the CPU too
def test_each_tree_is_that_of_its_boxes_alone(device):
    rng = np.random.default_rng(2)
    node = tlas_node_dtype(device)
    placed = rng.random((TREES, SIZE)) < 0.7
    placed[1], placed[3] = True, False  # all of them, and none
    forest = ForestBuilder(TREES, SIZE, device)
    lower = rng.uniform(-3, 3, (TREES * SIZE, 3)).astype(np.float32)
    forest.lower[:], forest.upper[:] = lower, lower + rng.uniform(0.1, 1, lower.shape).astype(np.float32)
    nodes = np.zeros((TREES * SIZE, *node.shape), node.base)
    order = np.zeros(TREES * SIZE, np.int32)
    counts = forest.build(placed, nodes, order)
    np.testing.assert_array_equal(counts, placed.sum(1))
    assert forest.node_bytes == SIZE * node.itemsize
    for tree in np.flatnonzero(placed.any(1)):
        first, rows = tree * SIZE, np.flatnonzero(placed[tree])
        alone, own_order = np.zeros((len(rows), *node.shape), node.base), np.zeros(SIZE, np.int32)
        lower, upper = (np.ascontiguousarray(each[first : first + SIZE]) for each in (forest.lower, forest.upper))
        count = TlasBuilder(lower, upper, alone, own_order, device).build(rows)
        built = nodes[first : first + count].copy()
        if device == "cpu":
            codes, expected = built.view(np.int32)[:, 48:56], alone[:count].view(np.int32)[:, 48:56]
            used = (expected < 0) & (built[:, :8] <= built[:, 24:32])  # leaves hold ~instance
            np.testing.assert_array_equal(~codes[used], ~expected[used] + first)
            codes[used] = expected[used]
        else:
            np.testing.assert_array_equal(built[:, 5], alone[:count, 5] + first)  # the first item of each node
            built[:, 5] = alone[:count, 5]
            np.testing.assert_array_equal(order[first : first + len(rows)], own_order[: len(rows)] + first)
        np.testing.assert_array_equal(built, alone[:count])
