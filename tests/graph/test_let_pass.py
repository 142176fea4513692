"""What Replicator lets pass: errors by default, warnings where `set_lenient` says so."""

import numpy as np
import pytest

import usdsdg as rep
from usdsdg import errors
from usdsdg.errors import BadPrim, GraphError, UsdsdgWarning


@pytest.fixture
def lenient():
    errors.set_lenient(True)
    yield
    errors.set_lenient(False)


def _modify_outside_of_a_block():
    rep.modify.pose(position=(0, 0, 1))


def _empty_get():
    with rep.get.prims(path_pattern="/Nothing"):
        rep.randomizer.color((1, 0, 0))


def _collider_of_nothing():
    with rep.get.prims(path_pattern="/Nothing"):
        rep.physics.collider()


def _too_few_weights():
    rep.distribution.choice(["a", "b"], weights=[1.0])


def _bounds_in_the_other_order():
    rep.distribution.uniform(1.0, 0.0)


@pytest.mark.parametrize(
    "call",
    [
        _modify_outside_of_a_block, _empty_get, _collider_of_nothing, _too_few_weights, _bounds_in_the_other_order,
    ],
)  # fmt: skip
def test_what_replicator_lets_pass_is_an_error_or_a_warning(stage, lenient, call):
    with pytest.warns(UsdsdgWarning):
        call()
    rep.orchestrator.preview()
    errors.set_lenient(False)
    with pytest.raises(GraphError):
        call()


def test_a_path_without_a_prim_is_left_out(stage, lenient):
    with pytest.warns(UsdsdgWarning, match="/World/Gone"):
        assert rep.get.prim_at_path(["/World", "/World/Gone"]).prims == ("/World",)
    errors.set_lenient(False)
    with pytest.raises(BadPrim):
        rep.get.prim_at_path("/World/Gone")


@pytest.mark.parametrize(
    ("weights", "frequencies"),
    [([0, 0], (0.5, 0.5)), ([1], (1.0, 0.0)), ([-1, 2], (0.0, 1.0)), ([1, 3, 5], (0.25, 0.75))],
)
def test_odd_weights_are_mended(stage, lenient, weights, frequencies):
    with pytest.warns(UsdsdgWarning, match="weights"):
        drawn = rep.distribution.choice([0, 1], weights=weights)
    picks = np.array(drawn.sample("test", 0, [f"/{i}" for i in range(4000)]))
    # Three standard deviations of 4,000 draws are 0.024.
    assert np.mean(picks == 0) == pytest.approx(frequencies[0], abs=0.025)
