"""Distributions have the moments and ranges of their names, per prim and per component."""

import os
import subprocess
import sys

import numpy as np
import pytest
from pxr import UsdShade
from scipy import stats

import usdsdg as rep
from usdsdg import distribution
from usdsdg.errors import GraphError, UnknownInput
from usdsdg.graph import evaluate
from usdsdg.graph.sampling import set_global_seed

PRIMS = [f"/World/p{i}" for i in range(3000)]


@pytest.fixture(autouse=True)
def _seed():
    set_global_seed(11)


def test_uniform_fills_its_range_in_each_component():
    values = distribution.uniform((-1, 0, 5.0), (1, 10, 5.0)).sample("n", 0, PRIMS)
    assert values.shape == (3000, 3)
    assert stats.kstest((values[:, 0] + 1) / 2, "uniform").pvalue > 1e-4
    assert stats.kstest(values[:, 1] / 10, "uniform").pvalue > 1e-4
    assert np.all(values[:, 2] == 5.0)


def test_integer_bounds_draw_floats_between_them():
    values = distribution.uniform((0, 0, 0), (1, 1, 1)).sample("n", 0, PRIMS)
    assert stats.kstest(values[:, 1], "uniform").pvalue > 1e-4


def test_normal_has_its_mean_and_deviation():
    values = distribution.normal(6500, 500).sample("n", 0, PRIMS)
    assert stats.kstest((values - 6500) / 500, "norm").pvalue > 1e-4


def test_log_uniform_is_uniform_in_the_logarithm():
    values = distribution.log_uniform(1e-3, 10.0).sample("n", 0, PRIMS)
    assert stats.kstest((np.log(values) - np.log(1e-3)) / np.log(1e4), "uniform").pvalue > 1e-4


def test_choice_follows_its_weights():
    drawn = distribution.choice(["a", "b", "c"], weights=[1, 0, 3]).sample("n", 0, PRIMS)
    assert "b" not in drawn
    # Binomial with n = 3000, p = 1/4: five standard deviations are 119.
    assert abs(drawn.count("a") - 750) < 119


def test_choice_without_replacement_repeats_no_item():
    drawn = distribution.choice(list(range(50)), with_replacements=False).sample("n", 0, PRIMS[:50])
    assert sorted(drawn) == list(range(50))
    with pytest.raises(GraphError, match="only 50 choices"):
        distribution.choice(list(range(50)), with_replacements=False).sample("n", 0, PRIMS[:51])


def test_choice_draws_from_nested_distributions():
    nested = distribution.choice([distribution.uniform(0.0, 1.0), distribution.uniform(10.0, 11.0)])
    values = np.array(nested.sample("n", 0, PRIMS))
    assert np.all((values < 1) | (values >= 10))
    assert 0.4 < (values < 1).mean() < 0.6


def test_each_execution_takes_one_item_of_a_sequence_for_all_prims():
    items = distribution.sequence(["a", "b", "c"])
    assert [items.sample("n", execution, ["/x", "/y"]) for execution in range(4)] == [
        ["a"] * 2,
        ["b"] * 2,
        ["c"] * 2,
        ["a"] * 2,
    ]


def test_each_execution_takes_one_distribution_of_a_sequence_for_all_prims():
    items = distribution.sequence(
        [distribution.uniform(0, 1), distribution.uniform(10, 11), distribution.uniform(20, 21)]
    )
    drawn = np.array([items.sample("c", execution, ["/a", "/b"]) for execution in range(6)]).reshape(6, 2)
    assert (drawn // 10).tolist() == [[0, 0], [1, 1], [2, 2]] * 2
    assert len(np.unique(drawn)) == 12
    with pytest.raises(GraphError, match="items has distributions, and 3, which is none"):
        distribution.sequence([distribution.uniform(0, 1), 3])


def test_a_shuffled_sequence_shows_every_item_once_per_cycle():
    items = distribution.sequence(list("abcdef"), ordered=False)
    cycles = [[items.sample("n", 6 * cycle + i, PRIMS[:1])[0] for i in range(6)] for cycle in range(2)]
    assert [sorted(cycle) for cycle in cycles] == [list("abcdef")] * 2
    assert cycles[0] != cycles[1]


def test_combine_takes_one_axis_from_each():
    values = distribution.combine([distribution.uniform(0.0, 1.0), 7.0]).sample("n", 0, PRIMS)
    assert np.all(values[:, 1] == 7.0)
    assert stats.kstest(values[:, 0], "uniform").pvalue > 1e-4


SEEDED = {
    "uniform": lambda seed: distribution.uniform((0, 0), (1, 1), seed=seed),
    "normal": lambda seed: distribution.normal((0, 0), (1, 1), seed=seed),
    "log_uniform": lambda seed: distribution.log_uniform((1, 1), (2, 2), seed=seed),
    "choice": lambda seed: distribution.choice(range(100), seed=seed),
}


@pytest.mark.parametrize(
    "make",
    [
        *SEEDED.values(),
        lambda seed: distribution.sequence(range(100), ordered=False, seed=seed),
    ],
    ids=[*SEEDED, "sequence"],
)
def test_a_seed_replaces_the_global_one(make):
    def drawn(seed):
        return np.array(make(seed).sample("n", 3, PRIMS[:20])).tolist()

    own = drawn(0)
    assert drawn(7) != own
    everyones = drawn(None)
    assert drawn(-1) == everyones
    set_global_seed(12)
    assert drawn(0) == own
    assert drawn(None) != everyones


@pytest.mark.parametrize(
    "make",
    [
        *SEEDED.values(),
        lambda seed: distribution.choice(range(100), seed=seed, with_replacements=False),
        lambda seed: distribution.choice([distribution.uniform((0, 0), (1, 1), seed=seed)]),
        lambda seed: distribution.combine([distribution.uniform(0, 1, seed=seed), 3.0]),
        lambda seed: distribution.sequence(range(100), ordered=False, seed=seed, stride=2),
    ],
    ids=[*SEEDED, "no replacements", "nested", "combine", "sequence"],
)
def test_draws_with_one_seed_go_together_whichever_nodes_and_prims_they_are_for(make):
    # As generators that are seeded alike: the n-th number of one is the n-th of the other.
    def drawn(seed, consumer, prims):
        return [np.array(make(seed).sample(consumer, execution, prims)).tolist() for execution in range(4)]

    left = drawn(5, "left", ["/World/Left", "/World/Left_01"])
    assert drawn(5, "right", ["/Other", "/Another"]) == left != drawn(6, "left", ["/World/Left", "/World/Left_01"])
    assert left[0] != left[1]
    assert left[0][0] != left[0][1]
    assert drawn(None, "left", ["/a", "/b"]) != drawn(None, "right", ["/a", "/b"])
    executions = np.arange(4)
    in_worlds = make(5).sample_worlds("right", executions, ["/Other", "/Another"])
    assert np.array_equal(np.asarray(in_worlds, float), np.asarray(left, float))


def test_a_seed_of_a_randomizer_keeps_its_draws_apart():
    parts = distribution.combine([distribution.uniform(0, 1), distribution.uniform(0, 1)]).seeded(5)
    (x, y), (other, _) = (parts.sample(consumer, 0, ["/a"])[0] for consumer in ("n", "m"))
    assert len({x, y, other}) == 3


def test_without_a_stride_each_prim_gets_a_vector_of_a_sequence():
    items = rep.distribution.sequence([(1, 0, 0), (2, 0, 0), (3, 0, 0)])
    assert [[x for x, _, _ in items.sample("n", execution, ["/x", "/y"])] for execution in range(2)] == [[1, 2], [3, 1]]
    items = rep.distribution.sequence([(1, 0, 0), (2, 0, 0), (3, 0, 0)], stride=1)
    assert [[x for x, _, _ in items.sample("n", execution, ["/x", "/y"])] for execution in range(2)] == [[1, 1], [2, 2]]


@pytest.mark.parametrize(
    ("stride", "first", "second"),
    [
        (None, "aaa", "bbb"), (0, "aaa", "bbb"), (1, "aaa", "bbb"), (2, "aba", "cdc"), (3, "abc", "def"),
        (5, "abc", "fab"), (-1, "aaa", "fff"),
    ],
)  # fmt: skip
def test_a_sequence_takes_and_advances_by_its_stride(stride, first, second):
    items = distribution.sequence(list("abcdef"), stride=stride)
    assert items.sample("n", 0, PRIMS[:3]) == list(first)
    assert items.sample("n", 1, PRIMS[:3]) == list(second)


def test_components_of_a_vector_are_uncorrelated():
    values = distribution.combine([distribution.normal(0, 1), distribution.normal(0, 1)]).sample("n", 0, PRIMS)
    # The correlation of 3000 independent pairs lies within four standard errors of 1 / sqrt(3000).
    assert abs(np.corrcoef(values.T)[0, 1]) < 4 / np.sqrt(len(PRIMS))


def test_a_number_is_broadcast_to_the_other_bound():
    values = distribution.uniform(0, (1, 2, 3)).sample("n", 0, PRIMS)
    np.testing.assert_allclose(values.max(0), (1, 2, 3), rtol=0.01)
    assert (values >= 0).all()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: distribution.uniform("low", 1), "lower is 'low'; expected a number"),
        (lambda: distribution.uniform(0, None), "upper is None; expected a number"),
        (lambda: distribution.uniform(0, float("inf")), "upper is inf"),
        (lambda: distribution.normal(0, [1, float("nan")]), r"std is \[1, nan\]"),
        (lambda: distribution.log_uniform((), 1), r"lower is \(\)"),
        (lambda: distribution.uniform(0, 1, seed="x"), "seed is 'x'; expected a whole number, or None"),
        (lambda: distribution.normal(0, 1, seed=1.5), "seed is 1.5"),
        (lambda: distribution.choice("/World/a.usd"), "choices is '/World/a.usd'; expected a list"),
        (lambda: distribution.choice(5), "choices is 5; expected a list"),
        (
            lambda: distribution.choice([[("class", distribution.choice(["a", "b"]))]]),
            r"choices\[0\] is a list with OgnSampleChoice .* in it; nothing would draw that",
        ),
        (
            lambda: distribution.sequence([1, (distribution.uniform(0, 1), 2)]),
            r"items\[1\] is a list with OgnSampleUniform .* in it",
        ),
        (lambda: distribution.choice([1, 2], weights=["a", 1]), "weights=.* must be 2 numbers"),
        (lambda: distribution.choice([1, 2], weights=[float("nan"), 1]), "weights=.* must be 2 numbers"),
        (lambda: distribution.sequence("abc"), "items is 'abc'; expected a list"),
        (lambda: distribution.sequence([1], stride="all"), "stride is 'all'; expected a whole number"),
        (lambda: distribution.combine(3), "distributions is 3; expected a list"),
        (lambda: distribution.combine([1, "x"]), "'x' is neither a number nor a distribution"),
    ],
)
def test_arguments_of_a_wrong_type_raise(make, message):
    with pytest.raises(GraphError, match=rf"\(made at test_distributions\.py:\d+\): {message}"):
        make()


def test_combined_vectors_bring_as_many_axes_as_they_have():
    both = distribution.combine([distribution.uniform((1, 2), (1, 2)), 5.0])
    np.testing.assert_allclose(both.sample("n", 0, PRIMS[:2]), [(1, 2, 5), (1, 2, 5)])
    worlds = both.sample_worlds("n", np.arange(3), PRIMS[:2])
    np.testing.assert_allclose(worlds, np.broadcast_to((1.0, 2.0, 5.0), (3, 2, 3)))


def test_draws_that_are_impossible_raise():
    once = distribution.choice(list("abc"), weights=[1, 1, 0], with_replacements=False)
    with pytest.raises(GraphError, match="3 prims but only 2 choices"):
        once.sample("n", 0, PRIMS[:3])


def test_inputs_can_be_set_with_or_without_their_prefix():
    drawn = distribution.uniform(0, 1)
    drawn.set_input("inputs:upper", 20)
    drawn.set_input("lower", 10)
    values = drawn.sample("n", 0, PRIMS)
    assert ((values >= 10) & (values < 20)).all()
    assert drawn.get_inputs() == {"lower": 10, "upper": 20}
    with pytest.raises(GraphError, match=r"OgnSampleUniform .* has no input 'uper'; did you mean 'upper'\?"):
        drawn.set_input("uper", 3)
    with pytest.raises(GraphError, match="expected a number"):
        drawn.set_input("lower", "low")


@pytest.mark.parametrize("kind", [distribution.uniform, distribution.log_uniform])
def test_bounds_are_set_one_after_the_other_in_either_order(kind):
    """Only draws need both: a range that moves up past its end has its lower bound above the upper one for a while."""
    drawn = kind(1, 2)
    drawn.set_input("lower", 30)
    with pytest.raises(GraphError, match="lower=30 is above upper=2"):
        drawn.sample("n", 0, PRIMS)
    drawn.set_input("upper", 40)
    values = drawn.sample("n", 0, PRIMS)
    assert ((values >= 30) & (values < 40)).all()
    drawn.set_input("lower", (1, 2))
    drawn.set_input("upper", (1, 2))
    drawn.set_input("lower", (1, 1, 1))
    with pytest.raises(GraphError, match="differ in length"):
        drawn.sample("n", 0, PRIMS)
    drawn.set_input("upper", (2, 2, 2))
    assert drawn.sample("n", 0, PRIMS[:2]).shape == (2, 3)
    assert drawn.get_inputs() == {"lower": (1, 1, 1), "upper": (2, 2, 2)}


def test_choices_and_their_weights_are_set_one_after_the_other():
    drawn = distribution.choice(["a", "b"], weights=[1, 1])
    drawn.set_input("choices", ["c", "d", "e"])
    with pytest.raises(GraphError, match="must be 3 numbers"):
        drawn.sample("n", 0, PRIMS)
    drawn.set_input("weights", [0, 0, 1])
    assert drawn.sample("n", 0, PRIMS[:2]) == ["e", "e"]
    with pytest.raises(GraphError, match="must be 3 numbers"):
        drawn.set_input("weights", [0, 0, -1])
    assert drawn.sample("n", 0, PRIMS[:2]) == ["e", "e"]


def test_a_range_that_moves_up_is_drawn_from_in_the_next_frame(stage):
    cube = rep.create.cube()
    with rep.trigger.on_frame(), cube:
        drawn = rep.distribution.uniform((0, 0, 0), (1, 1, 1))
        rep.modify.pose(position=drawn)
    prim = cube.get_output_prims()["prims"][0]
    for low in (0, 10, 20, 5):
        drawn.set_input("lower", (low,) * 3)
        drawn.set_input("upper", (low + 1,) * 3)
        rep.orchestrator.preview()
        assert all(low <= each <= low + 1 for each in prim.GetAttribute("xformOp:translate").Get())


@pytest.mark.parametrize(
    "make",
    [
        lambda: distribution.uniform(2, 1),
        lambda: distribution.uniform((0, 0), (1, 1, 1)),
        lambda: distribution.normal(0, -1),
        lambda: distribution.log_uniform(0, 1),
        lambda: distribution.choice([]),
        lambda: distribution.choice([1, 2], weights=[1]),
        lambda: distribution.sequence([]),
    ],
)
def test_impossible_parameters_name_the_script_line(make):
    with pytest.raises(GraphError, match=r"test_distributions\.py:\d+"):
        make()


def test_the_choice_of_one_distribution_is_its_draw():
    drawn = distribution.choice(distribution.sequence(["a", "b", "c"]), num_samples=9).sample("n", 1, PRIMS[:4])
    assert set(drawn) <= {"a", "b", "c"}


def test_what_was_drawn_last_is_an_output(stage):
    drawn = distribution.choice(rep.create.material_omnipbr(count=5))
    assert drawn.get_output("samples") == []
    with rep.create.cube(count=3) as cubes:
        rep.modify.material(drawn)
    evaluate.graph().evaluate()
    bound = [UsdShade.MaterialBindingAPI(prim).GetDirectBinding() for prim in cubes.get_output_prims()["prims"]]
    assert drawn.get_output("samples") == [str(each.GetMaterialPath()) for each in bound]


def test_targets_of_nodes_may_be_the_children_of_objects(stage):
    spheres = rep.create.sphere(count=2)
    for name in ("prims", "inputs:prims", "outputs:prims", "outputs_prims"):  # the last as in Omniverse's own examples
        assert rep.utils.get_node_targets(spheres.node, name) == list(spheres.prims)
    with pytest.raises(UnknownInput, match="has no input 'outputs:prim'; it has prims"):
        rep.utils.get_node_targets(spheres.node, "outputs:prim")
    inner = rep.utils.get_node_targets(spheres.node, "inputs:prims", replicatorXform=False)
    assert inner == [f"{path}/Sphere" for path in spheres.prims]


def test_sets_are_drawn_from_in_the_same_order_in_every_process():
    program = (
        "import usdsdg as rep; rep.set_global_seed(3); names = {'apple', 'pear', 'plum', 'fig', 'lime'}; "
        "print([kind(names).sample('node', 0, list('abcdef')) for kind in (rep.distribution.choice, "
        "rep.distribution.sequence)])"
    )
    outputs = {
        subprocess.run(
            [sys.executable, "-c", program], env=os.environ | {"PYTHONHASHSEED": str(seed)}, capture_output=True
        ).stdout
        for seed in (1, 2, 3)
    }
    assert len(outputs) == 1
    assert b"plum" in outputs.pop()


def test_a_set_has_no_weights():
    with pytest.raises(GraphError, match="choices is a set"):
        distribution.choice({"a", "b"}, weights=[1, 2])
