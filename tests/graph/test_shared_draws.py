"""A distribution that several nodes under one trigger take draws once for all, as one node of OmniGraph does."""

import numpy as np
import pytest

import usdsdg as rep
from usdsdg.app import saved_graph
from usdsdg.graph.evaluate import graph
from usdsdg.session import stage_context

pytestmark = pytest.mark.usefixtures("stage")


@pytest.fixture(autouse=True)
def _seed():
    rep.set_global_seed(7)


def _places(item):
    stage = stage_context.current_stage()
    return [tuple(stage.GetPrimAtPath(path).GetAttribute("xformOp:translate").Get()) for path in item.prims]


def _fired(*items):
    """Return the places of all items after each of two executions."""
    frames = []
    for capture in range(2):
        graph().evaluate(capture=capture, preview=capture == 0)
        frames.append([_places(item) for item in items])
    return frames


@pytest.mark.parametrize(
    "make",
    [
        lambda: rep.distribution.uniform((0, 0, 0), (9, 9, 9)),
        lambda: rep.distribution.normal((0, 0, 0), (1, 2, 3), name="place"),
        lambda: rep.distribution.choice([(1, 0, 0), (2, 0, 0), (3, 0, 0), (4, 0, 0), (5, 0, 0)]),
        lambda: rep.distribution.choice([(i, 0, 0) for i in range(9)], with_replacements=False),
        lambda: rep.distribution.choice([rep.distribution.uniform((i, 0, 0), (i + 1, 9, 9)) for i in range(3)]),
        lambda: rep.distribution.combine([rep.distribution.uniform(0, 9), 1, rep.distribution.normal(0, 1)]),
        lambda: rep.distribution.sequence([(i, 0, 0) for i in range(40)], ordered=False),
    ],
)
def test_nodes_under_one_trigger_get_the_same_draws(make):
    cones, cubes = rep.create.cone(count=4), rep.create.cube(count=4)
    shared = make()
    with rep.trigger.on_frame():
        for group in (cones, cubes):
            with group:
                rep.modify.pose(position=shared)
    frames = _fired(cones, cubes)
    for first, second in frames:
        assert first == second
    assert np.allclose(frames[1][0], np.array(shared.get_output("samples")))
    assert frames[0] != frames[1]
    assert len(set(frames[0][0])) > 1


def test_another_node_does_not_move_the_draws_of_the_first():
    def first_draws(groups):
        rep.new_stage()
        items = [rep.create.cone(count=3), rep.create.cube(count=5)][:groups]
        shared = rep.distribution.uniform((0, 0, 0), (9, 9, 9))
        with rep.trigger.on_frame():
            for item in items:
                rep.modify.pose(position=shared, input_prims=item)
        return _fired(*items)

    alone, together = first_draws(1), first_draws(2)
    for frame_alone, frame in zip(alone, together):
        assert frame_alone[0] == frame[0]
        assert frame[1][:3] == frame[0]
        # Two more prims than the first node has.
        assert len(set(frame[1])) == 5


def test_inputs_of_one_node_and_parts_of_vectors_share_a_draw():
    balls, boxes = rep.create.sphere(count=3), rep.create.cube(count=3)
    height = rep.distribution.uniform(1, 9)
    with rep.trigger.on_frame():
        with balls:
            rep.modify.pose(position=rep.distribution.combine([0, height, height]))
        with boxes:
            rep.modify.pose(position_x=height, position_z=height)
    for high, wide in _fired(balls, boxes):
        assert [(y, y) for _, y, _ in high] == [(y, z) for _, y, z in high] == [(x, z) for x, _, z in wide]
        assert len(set(high)) == 3


def test_triggers_draw_on_their_own():
    cones, cubes = rep.create.cone(count=4), rep.create.cube(count=4)
    shared = rep.distribution.uniform((0, 0, 0), (9, 9, 9))
    for group in (cones, cubes):
        with rep.trigger.on_frame(), group:
            rep.modify.pose(position=shared)
    for first, second in _fired(cones, cubes):
        assert not set(first) & set(second)


def test_objects_that_are_made_one_after_the_other_have_places_of_their_own():
    place = rep.distribution.uniform((0, 0, 0), (9, 9, 9))
    balls = [rep.create.sphere(position=place) for _ in range(4)]
    graph().evaluate()
    assert len({tuple(_places(ball)) for ball in balls}) == 4


def test_targets_that_are_set_later_keep_sharing():
    cones, cubes = rep.create.cone(count=2), rep.create.cube(count=4)
    shared = rep.distribution.uniform((0, 0, 0), (9, 9, 9))
    with rep.trigger.on_frame():
        rep.modify.pose(position=shared, input_prims=cones)
        second = rep.modify.pose(position=shared, input_prims=list(cubes.prims[:2]))
    _fired(cones)
    second.set_input("prims", list(cubes.prims[2:]))
    graph().evaluate(capture=3)
    assert _places(cubes)[2:] == _places(cones) != _places(cubes)[:2]


def test_a_loaded_graph_shares_draws_too():
    cones, cubes = rep.create.cone(count=3), rep.create.cube(count=3)
    shared = rep.distribution.uniform((0, 0, 0), (9, 9, 9))
    with rep.trigger.on_frame():
        for group in (cones, cubes):
            with group:
                rep.modify.pose(position=shared)
    expected = _fired(cones, cubes)
    saved_graph.load(stage_context.current_stage())
    assert _fired(cones, cubes) == expected
    assert expected[1][0] == expected[1][1]
