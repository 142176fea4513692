"""Draws are pure functions of their keys, uniform and independent."""

import subprocess
import sys

import numpy as np
import pytest
from scipy import stats

from usdsdg.errors import GraphError
from usdsdg.graph.sampling import generator, get_global_seed, set_global_seed, uniforms
from usdsdg.session.settings.store import get_settings

PRIMS = [f"/World/prim_{i}" for i in range(4000)]


def test_draws_are_uniform_in_every_component():
    u = uniforms(1, "node", 0, PRIMS, 3)
    assert u.min() >= 0.0
    assert u.max() < 1.0
    for component in range(3):
        # p below 1e-4 for a fixed seed would be a defect of the mixing function, not bad luck.
        assert stats.kstest(u[:, component], "uniform").pvalue > 1e-4


@pytest.mark.parametrize("other", [(2, "node", 0), (1, "other", 0), (1, "node", 1)])
def test_another_seed_node_or_execution_gives_uncorrelated_draws(other):
    first, second = uniforms(1, "node", 0, PRIMS, 1), uniforms(*other, PRIMS, 1)
    assert abs(np.corrcoef(first[:, 0], second[:, 0])[0, 1]) < 4 / np.sqrt(len(PRIMS))


def test_components_and_neighboring_prims_are_uncorrelated():
    u = uniforms(7, "node", 3, PRIMS, 2)
    limit = 4 / np.sqrt(len(PRIMS))
    assert abs(np.corrcoef(u[:, 0], u[:, 1])[0, 1]) < limit
    assert abs(np.corrcoef(u[:-1, 0], u[1:, 0])[0, 1]) < limit


def test_a_prims_draw_does_not_depend_on_the_others():
    everyone = uniforms(5, "node", 2, PRIMS[:10], 3)
    alone = uniforms(5, "node", 2, [PRIMS[7]], 3)
    assert np.array_equal(everyone[7:8], alone)


def test_draws_are_the_same_in_another_process():
    code = "from usdsdg.graph.sampling import uniforms; print(uniforms(3, 'n', 1, ['/a', '/b'], 2).tolist())"
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert printed.strip() == str(uniforms(3, "n", 1, ["/a", "/b"], 2).tolist())


def test_generators_differ_by_every_element_of_their_key():
    keys = [(1, "a", 0), (2, "a", 0), (1, "b", 0), (1, "a", 1), (1, "a", 0, "x")]
    assert len({generator(*key).integers(1 << 60) for key in keys}) == len(keys)


def test_zero_is_a_seed_and_negative_is_not():
    set_global_seed(0)
    assert get_global_seed() == 0
    with pytest.raises(GraphError, match="-1"):
        set_global_seed(-1)


@pytest.mark.parametrize("seed", ["three", 1.5, None])
def test_a_seed_is_a_whole_number(seed):
    set_global_seed(5)
    with pytest.raises(ValueError, match=f"global seed is {seed!r}; expected a whole number"):
        set_global_seed(seed)
    assert get_global_seed() == 5


def test_the_global_seed_is_also_a_setting():
    settings = get_settings()
    set_global_seed(5)
    assert settings.get("/omni/replicator/globalSeed") == 5
    settings.set("/omni/replicator/globalSeed", 9)
    assert get_global_seed() == 9
    settings.set("/omni/replicator/globalSeed", -1)
    drawn = get_global_seed()
    assert 0 <= drawn < 2**31
    assert get_global_seed() == drawn
