"""Distributions are what their names say, per prim and per component."""

import numpy as np
import pytest
from scipy import stats

from usdsdg import distribution
from usdsdg.errors import GraphError
from usdsdg.graph.sampling import set_global_seed

PRIMS = [f"/World/p{i}" for i in range(3000)]


@pytest.fixture(autouse=True)
def _seed():
    set_global_seed(11)


def test_uniform_fills_its_bounds_per_component():
    values = distribution.uniform((-1, 0, 5.0), (1, 10, 5.0)).sample("n", 0, PRIMS)
    assert values.shape == (3000, 3)
    assert stats.kstest((values[:, 0] + 1) / 2, "uniform").pvalue > 1e-4
    assert stats.kstest(values[:, 1] / 10, "uniform").pvalue > 1e-4
    assert np.all(values[:, 2] == 5.0)


def test_whole_numbers_as_bounds_draw_between_them():
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


def test_choice_without_replacement_repeats_nothing():
    drawn = distribution.choice(list(range(50)), with_replacements=False).sample("n", 0, PRIMS[:50])
    assert sorted(drawn) == list(range(50))
    with pytest.raises(GraphError, match="only 50 choices"):
        distribution.choice(list(range(50)), with_replacements=False).sample("n", 0, PRIMS[:51])


def test_choice_draws_from_nested_distributions():
    nested = distribution.choice([distribution.uniform(0.0, 1.0), distribution.uniform(10.0, 11.0)])
    values = np.array(nested.sample("n", 0, PRIMS))
    assert np.all((values < 1) | (values >= 10))
    assert 0.4 < (values < 1).mean() < 0.6


def test_sequence_steps_on_by_the_number_of_prims():
    items = distribution.sequence(["a", "b", "c"])
    assert items.sample("n", 0, ["/x", "/y"]) == ["a", "b"]
    assert items.sample("n", 1, ["/x", "/y"]) == ["c", "a"]


def test_shuffled_sequence_shows_every_item_once_a_lap():
    items = distribution.sequence(list("abcdef"), ordered=False)
    assert sorted(items.sample("n", 0, PRIMS[:6])) == list("abcdef")


def test_combine_takes_one_axis_from_each():
    values = distribution.combine([distribution.uniform(0.0, 1.0), 7.0]).sample("n", 0, PRIMS)
    assert np.all(values[:, 1] == 7.0)
    assert stats.kstest(values[:, 0], "uniform").pvalue > 1e-4


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
