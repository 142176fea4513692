"""First hits of rays against brute force over all triangles."""

import numpy as np

from tests.render import scenes
from tests.render.bvh.rays import brute_force, world_triangles
from tests.render.images import renderer_of

REACH = 3.0


def test_first_hits_are_those_of_brute_force():
    rng = np.random.default_rng(5)
    cubes = [(scenes.cube(), scenes.moved(rng.uniform(-2, 2, 3), scale=rng.uniform(0.2, 0.8, 3)), 0) for _ in range(12)]
    scene = scenes.scene_of(cubes, materials=[scenes.material()])
    origins = rng.uniform(-4, 4, (500, 3)).astype(np.float32)
    directions = rng.normal(size=(500, 3))
    directions = (directions / np.linalg.norm(directions, axis=1)[:, None]).astype(np.float32)
    found, instance = renderer_of(scene).first_hits(origins, directions, np.zeros(500), np.full(500, REACH))
    expected, doubt = brute_force(world_triangles(scene)[0], origins.astype(float), directions.astype(float))
    expected[expected > REACH] = np.inf
    sure = doubt > 1e-5
    assert (instance[sure] >= 0).sum() > 50
    np.testing.assert_allclose(found[sure], expected[sure], rtol=1e-4)
    np.testing.assert_array_equal(instance >= 0, np.isfinite(found))
