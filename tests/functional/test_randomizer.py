"""Colours, the scatter hook, and the generators that they draw from."""

import numpy as np
import pytest

from usdsdg import rng as rngs
from usdsdg.errors import BadPrim, Unsupported
from usdsdg.functional import create, create_batch, randomizer
from usdsdg.graph.sampling import set_global_seed
from usdsdg.rng import ReplicatorRNG


def colors(prims):
    return np.array([prim.GetAttribute("primvars:displayColor").Get()[0] for prim in prims])


def test_each_prim_gets_a_colour_of_its_own(stage):
    cubes = create_batch.cube(count=400)
    randomizer.display_color(cubes, rng=ReplicatorRNG(seed=5))
    drawn = colors(cubes)
    assert ((drawn >= 0) & (drawn <= 1)).all()
    # Mean of 400 uniform numbers: 0.5 within four standard errors of 0.289 / 20.
    np.testing.assert_allclose(drawn.mean(0), 0.5, atol=0.058)
    assert np.abs(np.corrcoef(drawn.T) - np.eye(3)).max() < 0.2
    randomizer.display_color(cubes, rng=np.random.default_rng(np.random.SeedSequence(5)))
    np.testing.assert_array_equal(colors(cubes), drawn)


def test_shapes_below_a_prim_share_its_colour(stage):
    group = create.xform()
    cubes = create_batch.cube(count=2, parent=group)
    randomizer.display_color(group)
    assert (colors(cubes)[0] == colors(cubes)[1]).all()
    with pytest.raises(BadPrim, match="/World has no shape"):
        randomizer.display_color("/World")


def test_without_a_generator_the_global_seed_decides(stage):
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


def test_a_generator_must_be_one(stage):
    with pytest.raises(TypeError, match="rng is 5; expected"):
        randomizer.display_color(create.cube(), rng=5)


def test_scatter_hands_prims_and_a_generator_to_whoever_provides_it(stage, monkeypatch):
    monkeypatch.setattr(randomizer, "_provided", {})
    cube, floor = create.cube(), create.plane()
    for name, where in (("scatter_2d", "surface_prims"), ("scatter_3d", "volume_prims")):
        with pytest.raises(Unsupported, match=f"functional.randomizer.{name}"):
            getattr(randomizer, name)(cube, floor)
        asked = {}
        randomizer.provide(name, lambda asked=asked, **arguments: asked.update(arguments))
        getattr(randomizer, name)(cube, floor, rng=ReplicatorRNG(1), check_for_collisions=True)
        assert asked["prims"] == [cube]
        assert asked[where] == [floor]
        assert asked["no_collision_prims"] == []
        assert asked["check_for_collisions"] is True
        assert asked["rng"].uniform() == ReplicatorRNG(1).generator.uniform()


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


def test_generators_begin_anew_with_the_global_seed_and_the_orchestrator():
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


def test_nodes_have_streams_of_their_own():
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


def test_a_new_seed_begins_anew():
    rng = ReplicatorRNG(1)
    rng.generator.uniform()
    rng.seed = 2
    assert rng.seed == 2
    assert rng.generator.uniform() == ReplicatorRNG(2).generator.uniform()
