"""Immediate random colors and positions, and their random generators."""

import numpy as np
import pytest
from pxr import UsdGeom

from tests.functional.poses import world
from usdsdg import rng as rngs
from usdsdg.errors import BadPrim, GraphError
from usdsdg.functional import create, create_batch, randomizer
from usdsdg.graph.sampling import set_global_seed
from usdsdg.rng import ReplicatorRNG


def colors(prims):
    return np.array([prim.GetAttribute("primvars:displayColor").Get()[0] for prim in prims])


def test_each_prim_gets_its_own_color(stage):
    cubes = create_batch.cube(count=400)
    randomizer.display_color(cubes, rng=ReplicatorRNG(seed=5))
    drawn = colors(cubes)
    assert ((drawn >= 0) & (drawn <= 1)).all()
    # Mean of 400 uniform numbers: 0.5 within four standard errors of 0.289 / 20.
    np.testing.assert_allclose(drawn.mean(0), 0.5, atol=0.058)
    assert np.abs(np.corrcoef(drawn.T) - np.eye(3)).max() < 0.2
    randomizer.display_color(cubes, rng=np.random.default_rng(np.random.SeedSequence(5)))
    np.testing.assert_array_equal(colors(cubes), drawn)


def test_shapes_below_a_prim_share_its_color(stage):
    group = create.xform()
    cubes = create_batch.cube(count=2, parent=group)
    randomizer.display_color(group)
    assert (colors(cubes)[0] == colors(cubes)[1]).all()
    with pytest.raises(BadPrim, match="/World has no shape"):
        randomizer.display_color("/World")


def test_without_a_generator_the_global_seed_is_used(stage):
    cubes = create_batch.cube(count=3)

    def drawn(seed):
        set_global_seed(seed)
        runs = []
        for _ in range(2):
            randomizer.display_color(cubes)
            runs.append(colors(cubes).tolist())
        return runs

    first = drawn(3)
    assert first[0] != first[1]
    assert drawn(4) != first
    assert drawn(3) == first


def test_an_invalid_generator_raises_an_error(stage):
    with pytest.raises(TypeError, match="rng is 5; expected"):
        randomizer.display_color(create.cube(), rng=5)


def positions(prims):
    return np.array([world(prim)[3, :3] for prim in prims])


def test_scatter_2d_covers_a_surface_uniformly(stage):
    floor = create.plane(parent="/World", scale=10, position=(0, 0, 2))
    cubes = create_batch.xform(count=400)
    randomizer.scatter_2d(cubes, floor, offset=0.5, rng=ReplicatorRNG(1))
    placed = positions(cubes)
    np.testing.assert_allclose(placed[:, 2], 2.5, atol=1e-5)
    assert (np.abs(placed[:, :2]) <= 5).all()
    # Mean of 400 uniform numbers in ±5: within four standard errors of 2.89 / 20.
    np.testing.assert_allclose(placed[:, :2].mean(0), 0, atol=0.58)
    randomizer.scatter_2d(cubes, floor, extents=((0, None, None), (1, None, None)), rng=ReplicatorRNG(1))
    assert ((positions(cubes)[:, 0] >= 0) & (positions(cubes)[:, 0] <= 1)).all()


def test_scattered_prims_avoid_each_other_and_obstacles(stage):
    floor = create.plane(scale=6)
    post = create.cube(scale=(3, 3, 1))
    cubes = create_batch.cube(count=8, name="small", scale=0.8)
    randomizer.scatter_2d(cubes, floor, post, check_for_collisions=True, rng=np.random.default_rng(2))
    placed = positions(cubes)
    apart = np.abs(placed[:, None] - placed[None]).max(-1) + 10 * np.eye(8)
    # Cubes of 0.8 that are not rotated touch unless one axis separates them.
    assert apart.min() >= 0.8 - 1e-6
    assert (np.abs(placed[:, :2]).max(1) >= 1.9 - 1e-6).all()


def test_scatter_3d_fills_volumes_and_boxes(stage):
    room = create.cube(scale=4, position=(0, 0, 2))
    hole = create.cube(scale=2, position=(0, 0, 2))
    prims = create_batch.xform(count=100)
    randomizer.scatter_3d(prims, room, volume_excl_prims=hole, viz_sampled_voxels=True, rng=ReplicatorRNG(1))
    inside = np.abs(positions(prims) - (0, 0, 2)).max(1)
    assert ((inside <= 2) & (inside >= 1)).all()
    assert stage.GetPrimAtPath("/Replicator/SampledVoxels").IsA(UsdGeom.PointInstancer)
    randomizer.scatter_3d(prims, extents=((5, 5, 5), (6, 6, 7)), rng=ReplicatorRNG(1))
    placed = positions(prims)
    assert ((placed >= (5, 5, 5)) & (placed <= (6, 6, 7))).all()


def test_voxels_overlaps_and_obstacles_of_scatter_3d(stage):
    volumes = create_batch.cube(count=2, position=[(0, 0, 0), (1, 0, 0)], scale=(2, 1, 1))
    prims, shares = create_batch.xform(count=400), []
    for once in (True, False):
        randomizer.scatter_3d(prims, volumes, prevent_vol_overlap=once, rng=ReplicatorRNG(2))
        shares.append(((positions(prims)[:, 0] > 0) & (positions(prims)[:, 0] < 1)).mean())
    # Binomial with n = 400: five standard deviations are 0.12.
    np.testing.assert_allclose(shares, (1 / 3, 1 / 2), atol=0.12)
    assert shares[0] < (1 / 3 + 1 / 2) / 2 < shares[1]
    for arguments, edge in (({"resolution_scaling": 0.5}, 2 / 15), ({"input_voxel_size": 0.25}, 0.25)):
        randomizer.scatter_3d(prims, volumes, viz_sampled_voxels=True, rng=ReplicatorRNG(2), **arguments)
        voxel = stage.GetPrimAtPath("/Replicator/SampledVoxels/Voxel")
        assert voxel.GetAttribute("size").Get() == pytest.approx(edge, rel=0.01)
    balls = create_batch.sphere(count=20, scale=0.2)
    randomizer.scatter_3d(
        balls, no_collision_prims=volumes, extents=((-2, -1, -1), (3, 1, 1)), check_for_collisions=True,
        rng=ReplicatorRNG(2),
    )  # fmt: skip
    placed = positions(balls)
    apart = np.linalg.norm(placed[:, None] - placed[None], axis=-1) + np.eye(20)
    assert apart.min() > 0.19
    assert not ((np.abs(placed - (0.5, 0, 0)) < (1.5, 0.5, 0.5)).all(1)).any()


def test_scatter_repeats_with_its_generator(stage):
    floor, prims = create.plane(), create_batch.xform(count=3)

    def drawn(rng):
        randomizer.scatter_2d(prims, floor, rng=rng)
        return positions(prims).tolist()

    rng = ReplicatorRNG(1)
    first = drawn(rng)
    assert drawn(rng) != first
    assert drawn(ReplicatorRNG(1)) == first
    set_global_seed(3)
    free = drawn(None)
    set_global_seed(4)
    assert drawn(None) != free
    set_global_seed(3)
    assert drawn(None) == free


def test_invalid_scatter_arguments_raise_errors(stage):
    cube = create.cube()
    with pytest.raises(GraphError, match="surface_prims is"):
        randomizer.scatter_2d(cube, [])
    with pytest.raises(GraphError, match="extents is 3; expected"):
        randomizer.scatter_2d(cube, cube, extents=3)
    with pytest.raises(GraphError):
        randomizer.scatter_3d(cube, extents=((0, 0, None), (1, 1, 1)))
    with pytest.raises(GraphError, match="resolution_scaling is 0"):
        randomizer.scatter_3d(cube, cube, resolution_scaling=0)


# --- ReplicatorRNG ---


def test_a_seed_gives_numpys_stream():
    ours = ReplicatorRNG(seed=42).generator.uniform(size=5)
    np.testing.assert_array_equal(ours, np.random.default_rng(np.random.SeedSequence(42)).uniform(size=5))


def test_without_a_seed_the_global_one_is_used():
    set_global_seed(7)
    expected = ReplicatorRNG(seed=7).generator.uniform(size=3)
    np.testing.assert_array_equal(ReplicatorRNG().generator.uniform(size=3), expected)
    np.testing.assert_array_equal(ReplicatorRNG(-1).generator.uniform(size=3), expected)
    assert ReplicatorRNG().seed is None


def test_generators_restart_with_the_global_seed_and_the_orchestrator():
    set_global_seed(7)
    free, fixed = ReplicatorRNG(), ReplicatorRNG(3)
    first = free.generator.uniform(), fixed.generator.uniform()
    rngs.reset_all()
    assert (free.generator.uniform(), fixed.generator.uniform()) == first
    set_global_seed(8)
    assert free.generator.uniform() != first[0]
    assert fixed.generator.uniform() == first[1]
    set_global_seed(7)
    assert free.generator.uniform() == first[0]


def test_each_node_has_its_own_random_stream():
    set_global_seed(7)
    draws = set()
    for node_id in range(4):
        rng = ReplicatorRNG(node="a")
        rng.initialize(None, "a", node_id)
        draws.add(rng.generator.uniform())
        expected = np.random.default_rng(np.random.SeedSequence((7, node_id))).uniform()
        rng.reset()
        assert rng.generator.uniform() == expected
    assert len(draws) == 4
    seeded = np.random.default_rng(np.random.SeedSequence((5, 0))).uniform()
    assert ReplicatorRNG(5, node="a").generator.uniform() == seeded


@pytest.mark.parametrize("seed", ["three", 1.5])
def test_a_seed_of_a_generator_is_a_whole_number(seed):
    with pytest.raises(GraphError, match=f"seed is {seed!r}; expected a whole number"):
        ReplicatorRNG(seed)


def test_a_new_seed_restarts_the_stream():
    rng = ReplicatorRNG(1)
    rng.generator.uniform()
    rng.seed = 2
    assert rng.seed == 2
    assert rng.generator.uniform() == ReplicatorRNG(2).generator.uniform()


def test_the_first_step_restarts_the_streams(stage):
    from usdsdg import orchestrator

    rng = ReplicatorRNG(1)
    first = rng.generator.uniform()
    orchestrator.stop()
    orchestrator.step()
    assert rng.generator.uniform() == first
    orchestrator.step()
    assert rng.generator.uniform() != first
