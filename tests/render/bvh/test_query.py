"""Ray queries: hits match brute force over all triangles, and shared edges are watertight."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tests.render import scenes
from tests.render.bvh.rays import brute_force, trace, world_triangles
from usdsdg_render.bvh import build
from usdsdg_render.bvh.acceleration_structure import LANES, LEAF_TRIANGLES, cpu_blas
from usdsdg_render.bvh.build import Builder
from usdsdg_render.bvh.query import MAX_BLAS_DEPTH, MAX_TLAS_DEPTH


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.diag(r))


def soup(rng: np.random.Generator, kind: str) -> scenes.Prototype:
    """Triangles that are hard for trees and intersection tests."""
    centers = rng.uniform(-1, 1, (300, 1, 3))
    if kind == "small":
        points = centers + rng.normal(size=(300, 3, 3)) * 0.1
    elif kind == "slivers":
        points = centers + rng.normal(size=(300, 3, 1)) * rng.normal(size=(300, 1, 3))
        points += rng.normal(size=(300, 3, 3)) * 1e-3
    elif kind == "coplanar":
        points = centers * [1, 1, 0] + rng.normal(size=(300, 3, 3)) * [0.2, 0.2, 0]
    elif kind == "all in one place":
        points = np.repeat(rng.normal(size=(1, 3, 3)), 300, 0)
    else:
        points = np.concatenate([centers + rng.normal(size=(300, 3, 3)) * 0.2] * 2)
        points[::3, 1] = points[::3, 0]  # no area
        points[1::7, 1] = 0.5 * (points[1::7, 0] + points[1::7, 2])
    points = points.reshape(-1, 3)
    return scenes.prototype(points, np.arange(len(points)).reshape(-1, 3))


@pytest.mark.parametrize("any_hit", [False, True])
@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 3e38])
def test_invalid_rays_hit_nothing_and_do_not_affect_others(wrong, any_hit):
    mesh = soup(np.random.default_rng(3), "small")
    turned = scenes.moved((0, 0, -3), scale=1e-3, rotation=random_rotation(np.random.default_rng(4)))
    scene = scenes.scene_of([(mesh, turned, 0), (scenes.square(), scenes.moved(), 0)])
    origins = np.tile([0.2, 0.1, 5.0], (7, 1))
    directions = np.tile([0.0, 0.0, -1.0], (7, 1))
    for k in range(3):
        origins[1 + k, k] = wrong
        directions[4 + k, k] = wrong
    found = trace(scene, origins, directions, any_hit=any_hit)["instance"]
    assert found[0] == (0 if any_hit else 1)
    assert (found[1:4] == -1).all()
    if not abs(wrong) < np.inf:
        assert (found == -1).sum() == 6


@pytest.mark.parametrize("kind", ["small", "slivers", "coplanar", "all in one place", "degenerate"])
def test_hits_match_brute_force(kind):
    rng = np.random.default_rng(7)
    mesh = soup(rng, kind)
    scene = scenes.scene_of(
        [
            (mesh, scenes.moved(), 0),
            (mesh, scenes.moved((0.5, 3, -1), scale=(0.2, 2.0, 1.0), rotation=random_rotation(rng)), 0),
            (scenes.cube(), scenes.moved((-3, 0, 0), scale=0.7, rotation=random_rotation(rng)), 0),
        ]
    )
    origins = rng.uniform(-5, 5, (400, 3)).astype(np.float32)
    toward = rng.uniform(-1.5, 3.5, (400, 3)) * [1, 1, 0.5] - origins
    directions = (toward / np.linalg.norm(toward, axis=1, keepdims=True)).astype(np.float32)
    triangles, owners = world_triangles(scene)
    expected, doubt = brute_force(triangles, origins.astype(float), directions.astype(float))
    hits = trace(scene, origins, directions)
    found = np.where(hits["instance"] >= 0, hits["t"], np.inf)
    # In float32 a ray within 1e-4 of an edge (in barycentric weights) may pass on either side of it.
    sure = doubt > 1e-4
    assert sure.mean() > 0.7
    assert np.isfinite(expected[sure]).any()
    np.testing.assert_array_equal(np.isfinite(found[sure]), np.isfinite(expected[sure]))
    both = sure & np.isfinite(expected)
    np.testing.assert_allclose(found[both], expected[both], rtol=2e-4, atol=1e-5)
    # The hit point lies at the barycentric coordinates.
    hit = both & (hits["instance"] >= 0)
    first = np.searchsorted(owners, hits["instance"][hit])
    corners = triangles[first + hits["triangle"][hit]]
    weights = np.stack([1 - hits["u"] - hits["v"], hits["u"], hits["v"]], -1)[hit]
    at = (corners * weights[..., None]).sum(1)
    np.testing.assert_allclose(at, (origins + directions * hits["t"][:, None])[hit], atol=5e-4)
    # Occlusion: the same with a maximum distance.
    shadow = trace(
        scene, origins, directions, reach=np.where(np.isfinite(expected), expected * 1.01, 1e30), any_hit=True
    )
    np.testing.assert_array_equal(shadow["instance"][sure] >= 0, np.isfinite(expected[sure]))
    short = trace(scene, origins[both], directions[both], reach=expected[both] * 0.99, any_hit=True)
    assert (short["instance"] < 0).all()


@pytest.mark.parametrize("aim", ["edges", "corners", "anywhere"])
@pytest.mark.parametrize("scale", [1e-4, 1.0, 3e3])
def test_no_ray_leaves_a_closed_mesh(aim, scale):
    rng = np.random.default_rng(3)
    mesh = scenes.sphere(rings=24)
    rotation = random_rotation(rng)
    scene = scenes.scene_of([(mesh, scenes.moved((3 * scale, -2 * scale, scale), scale=scale, rotation=rotation), 0)])
    triangles, _ = world_triangles(scene)
    pick = triangles[rng.integers(0, len(triangles), 20000)]
    part = rng.random((20000, 1))
    if aim == "edges":
        targets = pick[:, 0] * part + pick[:, 1] * (1 - part)
    elif aim == "corners":
        targets = pick[:, 0]
    else:
        targets = pick.mean(1)
    origin = np.array([3, -2, 1]) * scale + rng.uniform(-0.3, 0.3, 3) * scale
    hits = trace(scene, origin, (targets - origin) / np.linalg.norm(targets - origin, axis=1, keepdims=True))
    assert (hits["instance"] == 0).all()


@pytest.mark.parametrize("axis", range(3))
def test_rays_along_axes_through_a_grid_of_shared_edges(axis):
    """Directions with zero components, and edges that the rays hit exactly."""
    n = 16
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    flat = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], -1)
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    a = (i * (n + 1) + j).ravel()
    triangles = np.concatenate([np.stack([a, a + n + 1, a + n + 2], -1), np.stack([a, a + n + 2, a + 1], -1)])
    points = np.roll(flat, axis + 1, 1)
    scene = scenes.scene_of([(scenes.prototype(points, triangles), scenes.moved(), 0)])
    inner = np.arange(1, 2 * n) / 2
    u, v = np.meshgrid(inner, inner, indexing="ij")
    at = np.roll(np.stack([u.ravel(), v.ravel(), 0 * u.ravel()], -1), axis + 1, 1)
    for sign in (-1.0, 1.0):
        direction = np.roll([0.0, 0.0, sign], axis + 1)
        hits = trace(scene, at - 3 * direction, direction)
        assert (hits["instance"] == 0).all()
        np.testing.assert_array_equal(hits["t"], 3.0)


def test_an_instance_without_shadow_is_hit_but_does_not_occlude():
    scene = scenes.scene_of([(scenes.cube(), scenes.moved(), 0)])
    scene.instances.casts_shadow[:] = 0
    assert trace(scene, (0, 0, 5), (0, 0, -1))["instance"][0] == 0
    assert trace(scene, (0, 0, 5), (0, 0, -1), any_hit=True)["instance"][0] == -1


def test_an_empty_scene_has_no_hits_and_flat_instances_are_skipped():
    assert trace(scenes.scene_of([]), (0, 0, 5), (0, 0, -1))["instance"][0] == -1
    flat = scenes.scene_of([(scenes.cube(), scenes.moved(scale=(1, 1, 0)), 0), (scenes.cube(), scenes.moved(), 0)])
    with pytest.warns(UserWarning, match="object_0"):
        hits = trace(flat, (0, 0, 5), (0, 0, -1))
    assert hits["instance"][0] == 1


def test_trees_stay_within_their_depth_limit():
    rng = np.random.default_rng(0)
    # With boxes of geometrically growing size the surface area heuristic splits off one at a time.
    size = (4.0 ** np.arange(-20, 20))[:, None].astype(np.float32)
    lower, upper = np.repeat(-size, 3, 1), np.repeat(size, 3, 1)
    lower, upper = np.tile(lower, (50, 1)), np.tile(upper, (50, 1))
    builder = Builder(lower, upper, len(lower), max_depth=MAX_TLAS_DEPTH)
    builder.build()
    assert builder.depth <= MAX_TLAS_DEPTH
    corners = (rng.normal(size=(3000, 3, 3)) * 10.0 ** rng.uniform(-12, 6, (3000, 1, 1))).astype(np.float32)
    lower, upper = corners.min(1), corners.max(1)
    builder = Builder(lower, upper, 3000, block=LANES, leaf=LEAF_TRIANGLES, max_depth=MAX_BLAS_DEPTH)
    _, blocks = builder.build()
    assert builder.depth <= MAX_BLAS_DEPTH
    members = builder.members[:blocks]
    assert sorted(members[members >= 0]) == list(range(3000))


def shells(sizes) -> scenes.Prototype:
    """Nested cubes around the origin."""
    cube = scenes.cube()
    points = np.concatenate([cube.points * np.float32(size) for size in sizes])
    triangles = np.concatenate([cube.triangles + 8 * k for k in range(len(sizes))])
    return scenes.prototype(points, triangles)


def test_trees_of_nested_boxes_lose_no_hit():
    """Nested boxes: a ray hits all children of all nodes, which maximizes its stack."""
    rng = np.random.default_rng(1)
    inner, outer = 1.5 ** np.arange(-20.0, 21.0), 4.0 ** np.arange(-8.0, 9.0)
    mesh = shells(np.tile(inner, 6))
    placed = [(mesh, scenes.moved(scale=scale), 0) for scale in np.tile(outer, 25)]
    sizes = (inner.astype(np.float32)[:, None] * outer).ravel()
    origins = rng.normal(size=(1500, 3)) * 10.0 ** rng.uniform(-7, 5, (1500, 1))
    directions = (
        rng.normal(size=(1500, 3)) - origins * rng.uniform(0, 3, (1500, 1)) / np.linalg.norm(origins, axis=1)[:, None]
    )
    directions = (directions / np.linalg.norm(directions, axis=1, keepdims=True)).astype(np.float32)
    origins = origins.astype(np.float32)
    at, d = origins.astype(float)[:, None], directions.astype(float)[:, None]
    near, far = (-np.sign(d) * sizes[:, None] - at) / d, (np.sign(d) * sizes[:, None] - at) / d
    near, far = near.max(-1), far.min(-1)
    t = np.where(near > 0, near, far)
    expected = np.where((far > 0) & (near <= far), t, np.inf).min(1)
    # In float32 a ray that touches an edge may miss it.
    sure = ~((far > 0) & (np.abs(far - near) < 1e-4 * far)).any(1)
    assert sure.mean() > 0.9
    scene = scenes.scene_of(placed)
    found = trace(scene, origins, directions)
    met = np.isfinite(expected)
    assert met.mean() > 0.9
    np.testing.assert_array_equal((found["instance"] >= 0)[sure], met[sure])
    off = np.abs(found["t"] - expected)[met & sure]
    assert (off < (1e-4 * expected + 1e-6 * np.abs(origins).max(1))[met & sure]).all()
    assert (trace(scene, origins[met], directions[met], any_hit=True)["instance"] >= 0).all()


@pytest.mark.parametrize("apart", [1e-3, 1e-5])
def test_the_first_of_many_thin_layers_is_hit(apart):
    rng = np.random.default_rng(2)
    order = rng.permutation(200)
    square = scenes.square()
    points = np.concatenate([square.points + np.float32([0, 0, apart * k]) for k in order])
    mesh = scenes.prototype(points, np.concatenate([square.triangles + 4 * k for k in range(200)]))
    layers = [(square, scenes.moved((0, 0, apart * k)), 0) for k in order]
    origins = np.concatenate([rng.uniform(-0.9, 0.9, (500, 2)), np.full((500, 1), 2.0)], 1)
    for placed in ([(mesh, scenes.moved(), 0)], layers):
        hits = trace(scenes.scene_of(placed), origins, (0, 0, -1))
        np.testing.assert_allclose(hits["t"], 2 - apart * 199, atol=0.4 * apart)
        below = trace(scenes.scene_of(placed), origins * (1, 1, -1), (0, 0, 1))
        np.testing.assert_allclose(below["t"], 2.0, atol=0.4 * apart)


def test_the_first_of_many_distant_particles_is_hit():
    """Thousands of distant boxes whose entry distances differ by less than a thousandth."""
    rng = np.random.default_rng(9)
    grains = rng.uniform(-0.03, 0.03, (3000, 1, 3)) + rng.normal(size=(3000, 3, 3)) * 2e-3
    mesh = scenes.prototype(grains.reshape(-1, 3), np.arange(9000).reshape(-1, 3))
    clouds = [scenes.moved(), scenes.moved((0.01, 0.02, -0.01), rotation=random_rotation(rng))]
    scene = scenes.scene_of([(mesh, cloud, 0) for cloud in clouds])
    origins = rng.normal(size=(600, 3))
    origins *= 3 / np.linalg.norm(origins, axis=1, keepdims=True)
    directions = rng.uniform(-0.03, 0.03, (600, 3)) - origins
    origins = origins.astype(np.float32)
    directions = (directions / np.linalg.norm(directions, axis=1, keepdims=True)).astype(np.float32)
    expected, doubt = brute_force(world_triangles(scene)[0], origins.astype(float), directions.astype(float))
    sure = doubt > 1e-3
    assert (sure & np.isfinite(expected)).sum() > 100
    found = trace(scene, origins, directions)
    found = np.where(found["instance"] >= 0, found["t"], np.inf)
    np.testing.assert_allclose(found[sure], expected[sure], rtol=3e-5)


def test_the_native_code_uses_no_structs_of_warps_headers():
    """They use only Warp's native vector types, which every native function returns: no mesh, BVH or query types."""
    folder = Path(build.__file__).parent
    sources = sorted(folder.glob("*.cpp"))
    names = {"build_tree.cpp", "compress_tree.cpp", "compressed.cpp", "tile.cpp", "traverse.cpp"}
    assert {each.name for each in sources} == names
    for source in sources:
        code = re.sub(r"//[^\n]*", "", source.read_text())
        assert set(re.findall(r"wp::(\w+)", code)) <= {"vec_t", "uint32"}, source.name
        assert not re.search(r"#\s*include|bvh_|mesh_|\bBVH\b|\bMesh\b", code), source.name
    for module in ("build", "compress", "acceleration_structure", "query", "tile"):
        code = (folder / f"{module}.py").read_text()
        assert not re.search(r"wp\.(Mesh|Bvh|mesh_|bvh_)", code), module


def test_tree_memory_is_aligned_to_cache_lines():
    mesh = scenes.sphere(rings=12)
    nodes, blocks = cpu_blas(mesh.points, mesh.triangles)
    assert nodes.ctypes.data % 64 == 0
    assert blocks.ctypes.data % 64 == 0
