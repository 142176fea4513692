"""Positions of the nodes in, on and between spheres."""

import numpy as np
import pytest
from scipy import stats

import usdsdg as rep
from usdsdg.errors import GraphError
from usdsdg.graph import evaluate
from usdsdg.randomizer.spheres import points_between


def translations(stage, item):
    return np.array([stage.GetPrimAtPath(path).GetAttribute("xformOp:translate").Get() for path in item.prims])


@pytest.mark.parametrize("extension", ["isaacsim.replicator.examples", "omni.replicator.isaac"])
def test_wrapped_nodes_move_the_prims_of_their_group(stage, extension):
    @rep.utils.ReplicatorWrapper
    def sample(kind, input_prims=None, **radii):
        node = rep.utils.create_node(f"{extension}.{kind}", **radii)
        if input_prims:
            rep.utils.set_target_prims(node, "inputs:prims", input_prims)
        return node

    groups = [rep.create.xform(count=50) for _ in range(4)]
    with rep.trigger.on_custom_event("go"):
        with groups[0]:
            sample("OgnSampleInSphere", radius=0.5)
        with groups[1]:
            sample("OgnSampleOnSphere", radius=1.5)
        with groups[2]:
            sample("OgnSampleBetweenSpheres", radius1=3.5, radius2=2.5)
        sample("OgnSampleOnSphere", input_prims=groups[3])
    seen = []
    for _ in range(2):
        rep.utils.send_og_event("go")
        evaluate.graph().evaluate()
        distances = [np.linalg.norm(translations(stage, group), axis=1) for group in groups]
        seen.append(distances)
        assert distances[0].max() < 0.5
        np.testing.assert_allclose(distances[1], 1.5, rtol=1e-6)
        assert 2.5 < distances[2].min() < distances[2].max() < 3.5
        np.testing.assert_allclose(distances[3], 1.0, rtol=1e-6)
    assert not np.array_equal(seen[0][0], seen[1][0])


@pytest.mark.parametrize("bounds", [(0.0, 2.0), (1.0, 3.0), (2.0, 2.0)])
def test_points_are_uniform_by_volume_and_direction(bounds):
    inner, outer = bounds
    points = points_between(np.random.default_rng(1).random((5000, 3)), inner, outer)
    distance = np.linalg.norm(points, axis=1)
    # Archimedes: each coordinate of a direction is uniform on [-1, 1].
    for axis in range(3):
        assert stats.kstest(points[:, axis] / distance, stats.uniform(-1, 2).cdf).pvalue > 0.001
    if inner < outer:
        volume = (distance**3 - inner**3) / (outer**3 - inner**3)
        assert stats.kstest(volume, "uniform").pvalue > 0.001


def test_a_negative_radius_is_an_error(stage):
    with rep.trigger.on_custom_event("go"), rep.create.xform():
        rep.utils.create_node("isaacsim.replicator.examples.OgnSampleInSphere", radius=-1)
    rep.utils.send_og_event("go")
    with pytest.raises(GraphError, match="radius is -1; expected a number, 0 or more"):
        evaluate.graph().evaluate()
