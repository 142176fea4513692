"""Compressed trees of CUDA give the hits of the CPU, bit for bit."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render import scenes
from tests.render.bvh import compress_by_numpy, compressed_on_cpu
from tests.render.bvh.rays import trace
from tests.render.bvh.test_query import random_rotation, shells, soup
from usdsdg_render.bvh.acceleration_structure import cuda_blas
from usdsdg_render.bvh.build import Builder
from usdsdg_render.bvh.compress import LEAF_ITEMS, NODE_WORDS, Compressor
from usdsdg_render.device.device_scene import DeviceScene


def rays_through(rng: np.random.Generator, count: int, size: float) -> tuple[np.ndarray, np.ndarray]:
    origins = rng.uniform(-size, size, (count, 3)).astype(np.float32)
    directions = rng.normal(size=(count, 3))
    directions[: count // 4, rng.integers(0, 3)] = 0.0  # parallel to coordinate planes
    return origins, (directions / np.linalg.norm(directions, axis=1, keepdims=True)).astype(np.float32)


def assert_same_hits(scene, origins, directions, reach=1e30, overlapping=False) -> None:
    on_device = DeviceScene("cpu")
    on_device.sync(scene)
    expected = trace(on_device, origins, directions, reach=reach)
    reaches = np.broadcast_to(np.float32(reach), len(origins)).copy()
    found = compressed_on_cpu.trace(on_device, scene, origins, directions, reach=reaches)
    hit = expected["instance"] >= 0
    np.testing.assert_array_equal(found[:, 3] >= 0, hit)
    # Where triangles overlap in one plane, each may be the one, to the last bit of t.
    np.testing.assert_allclose(found[hit, 0].view(np.float32), expected["t"][hit], rtol=5e-7)
    same = hit & (found[:, 3] == expected["instance"]) & (found[:, 4] == expected["triangle"])
    assert overlapping or (same == hit).all()
    for word, name in enumerate("tuv"):
        np.testing.assert_array_equal(found[same, word].view(np.float32), expected[name][same])
    blocked = compressed_on_cpu.trace(on_device, scene, origins, directions, reach=reaches, any_hit=True)
    np.testing.assert_array_equal(blocked[:, 3] >= 0, hit)


@pytest.mark.parametrize("kind", ["small", "slivers", "coplanar", "all in one place", "degenerate"])
def test_hits_are_those_of_the_cpu(kind):
    rng = np.random.default_rng(11)
    mesh = soup(rng, kind)
    scene = scenes.scene_of(
        [
            (mesh, scenes.moved(), 0),
            (mesh, scenes.moved((0.5, 3, -1), scale=(0.2, 2.0, 1.0), rotation=random_rotation(rng)), 0),
            (scenes.cube(), scenes.moved((-3, 0, 0), scale=0.7, rotation=random_rotation(rng)), 0),
        ]
    )
    overlapping = kind not in ("small", "slivers")
    assert_same_hits(scene, *rays_through(rng, 4000, 4.0), overlapping=overlapping)
    assert_same_hits(scene, *rays_through(rng, 1000, 4.0), reach=1.5, overlapping=overlapping)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_many_instances_near_and_far(scale):
    rng = np.random.default_rng(2)
    ball = scenes.sphere(rings=24)
    placed = [
        (ball, scenes.moved(rng.uniform(-4, 4, 3) * scale, scale=rng.uniform(0.05, 0.6) * scale), 0) for _ in range(200)
    ]
    origins, directions = rays_through(rng, 4000, 5.0)
    assert_same_hits(scenes.scene_of(placed), origins * np.float32(scale), directions)


def test_nested_geometry_fills_the_stack_and_loses_no_hit():
    rng = np.random.default_rng(3)
    mesh = shells(np.tile(1.5 ** np.arange(-20.0, 21.0), 6))
    placed = [(mesh, scenes.moved(scale=scale), 0) for scale in np.tile(4.0 ** np.arange(-8.0, 9.0), 25)]
    origins, directions = rays_through(rng, 1000, 1.0)
    origins *= np.float32(10.0) ** rng.uniform(-7, 5, (1000, 1)).astype(np.float32)
    assert_same_hits(scenes.scene_of(placed), origins, directions, overlapping=True)


def test_every_triangle_is_in_one_leaf():
    mesh = soup(np.random.default_rng(1), "small")
    nodes, corners = cuda_blas(mesh.points, mesh.triangles)
    order = corners[:, 0, 3].view(np.int32)
    assert sorted(order) == list(range(len(mesh.triangles)))
    np.testing.assert_array_equal(corners[..., :3], mesh.points[mesh.triangles[order]])
    meta = nodes.view(np.uint8)[:, 24:32]
    leaves = (meta > 0) & (meta & 24 != 24)
    items = np.array([bin(byte >> 5).count("1") for byte in meta[leaves]])
    assert items.sum() == len(mesh.triangles)
    assert items.max() <= LEAF_ITEMS


@pytest.mark.parametrize(
    ("count", "block", "scale"), [(1, 1, 1.0), (2, 2, 1.0), (9, 1, 1e-6), (700, 1, 1e5), (3000, 2, 1.0)]
)
def test_nodes_are_those_of_the_slow_twin(count, block, scale):
    rng = np.random.default_rng(count)
    middle, half = rng.normal(size=(count, 3)) * scale, rng.exponential(size=(count, 3)) * 0.05 * scale
    lower, upper = (middle - half).astype(np.float32), (middle + half).astype(np.float32)
    builder = Builder(lower, upper, count, block=block, leaf=block, max_depth=20)
    nodes, order = np.full((count, NODE_WORDS), 7, np.uint32), np.empty(count, np.int32)
    compressor = Compressor(builder, nodes, order)
    for _ in range(2):  # memory that was used before makes no difference
        built, blocks = builder.build()
        used = nodes[: compressor.compress()]
        expected, items = compress_by_numpy.compress(builder.nodes[:built], builder.members[:blocks], block)
        np.testing.assert_array_equal(used, expected)
        np.testing.assert_array_equal(order, items)
        lower -= np.float32(scale) * rng.random((count, 3), np.float32)
