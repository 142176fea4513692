"""Choices and sequences of prims are items of prims that are drawn: nodes act on others at each execution."""

import pytest

import usdsdg as rep
from usdsdg.app import saved_graph
from usdsdg.errors import BadPrim, GraphError
from usdsdg.graph.evaluate import graph
from usdsdg.session import stage_context

pytestmark = pytest.mark.usefixtures("stage")


@pytest.fixture(autouse=True)
def _seed():
    rep.set_global_seed(3)


def _shown(item):
    """Return the paths of the prims of an item that are visible."""
    prims = item.get_output_prims()["prims"]
    return [str(prim.GetPath()) for prim in prims if prim.GetAttribute("visibility").Get() != "invisible"]


def _frames(item, count):
    frames = []
    for capture in range(count):
        graph().evaluate(capture=capture, preview=capture == 0)
        frames.append(_shown(item))
    return frames


def _hide_all_but(item, drawn):
    with rep.trigger.on_frame():
        with item:
            rep.modify.visibility(False)
        with drawn:
            rep.modify.visibility(True)


def test_each_execution_draws_as_many_prims_as_asked_for():
    cubes = rep.create.cube(count=5)
    drawn = rep.distribution.choice(cubes, num_samples=2, with_replacements=False)
    _hide_all_but(cubes, drawn)
    frames = _frames(cubes, 40)
    assert {len(frame) for frame in frames} == {2}
    assert len({tuple(frame) for frame in frames}) > 5
    # Binomial with n = 40, p = 2/5: five standard deviations are 15.5.
    assert all(abs(sum(path in frame for frame in frames) - 16) < 15.5 for path in cubes.prims)


def test_all_nodes_of_a_block_act_on_the_same_prims():
    cubes = rep.create.cube(count=4)
    drawn = rep.distribution.choice(cubes)
    with rep.trigger.on_frame():
        with cubes:
            rep.modify.visibility(False)
            rep.modify.pose(position=(0, 0, 0))
        rep.modify.visibility(True, input_prims=drawn)
        with drawn:
            rep.modify.pose(position=rep.distribution.uniform((1, 1, 1), (2, 2, 2)))
    for capture in range(6):
        graph().evaluate(capture=capture, preview=capture == 0)
        moved = [
            str(prim.GetPath())
            for prim in cubes.get_output_prims()["prims"]
            if tuple(prim.GetAttribute("xformOp:translate").Get()) != (0, 0, 0)
        ]
        assert moved == _shown(cubes) == list(drawn.get_output("prims"))


def test_a_chosen_prim_is_scattered_alone():
    plane = rep.create.plane(visible=False, scale=20)
    makers = (rep.create.cube, rep.create.sphere, rep.create.cone)
    shapes = [make(semantics=[("class", "distractor")]) for make in makers]
    found = rep.get.prims(semantics=[("class", "distractor")])
    with rep.trigger.on_frame():
        chosen = rep.distribution.choice(found, with_replacements=False, seed=10)
        rep.randomizer.scatter_2d(plane, check_for_collisions=True, seed=0, input_prims=chosen)
    graph().evaluate(preview=True)
    places = [shape.get_output_prims()["prims"][0].GetAttribute("xformOp:translate").Get() for shape in shapes]
    assert sum(tuple(place) != (0, 0, 0) for place in places) == 1


def test_a_sequence_acts_on_one_prim_after_the_other():
    cubes = rep.create.cube(count=3)
    one_by_one = rep.distribution.sequence([str(path) for path in cubes.prims])
    _hide_all_but(cubes, rep.get.prim_at_path(one_by_one))
    assert _frames(cubes, 4) == [[cubes.prims[index]] for index in (0, 1, 2, 0)]


def test_two_choices_draw_on_their_own():
    cubes = rep.create.cube(count=9)
    first, second = rep.distribution.choice(cubes), rep.distribution.choice(cubes)
    with rep.trigger.on_frame():
        rep.modify.visibility(True, input_prims=first)
        rep.modify.visibility(True, input_prims=second)
    drawn = []
    for capture in range(12):
        graph().evaluate(capture=capture, preview=capture == 0)
        drawn.append((first.prims, second.prims))
    assert any(one != other for one, other in drawn)


def test_a_loaded_graph_draws_the_same_prims():
    cubes = rep.create.cube(count=5)
    _hide_all_but(cubes, rep.distribution.choice(cubes, num_samples=2, with_replacements=False))
    expected = _frames(cubes, 6)
    saved_graph.load(stage_context.current_stage())
    assert _frames(cubes, 6) == expected


def test_prims_of_a_group_in_a_list_count_each():
    group, single = rep.create.cube(count=3), rep.create.sphere()
    drawn = rep.distribution.choice([group, single]).sample("n", 0, [str(place) for place in range(2000)])
    # Binomial with n = 2000, p = 1/4: five standard deviations are 97.
    assert all(abs(drawn.count(path) - 500) < 97 for path in (*group.prims, *single.prims))


def test_weights_are_those_of_the_groups():
    group, single = rep.create.cube(count=3), rep.create.sphere()
    drawn = rep.distribution.choice([group, single], weights=[0, 1]).sample("n", 0, ["a", "b"])
    assert drawn == [single, single]


def test_what_draws_no_prims_is_an_error_where_prims_are_acted_on():
    with rep.trigger.on_frame(), pytest.raises(GraphError, match="no prims to act on"):
        rep.modify.visibility(True, input_prims=rep.distribution.choice(["red", "blue"]))
    with pytest.raises(BadPrim, match="does not draw from prims"):
        rep.get.prim_at_path(rep.distribution.choice(["red", "blue"]))
    cubes = rep.create.cube(count=2)
    with rep.trigger.on_frame(), pytest.raises(GraphError, match="num_samples is 0; expected a whole number, 1 or"):
        rep.modify.visibility(True, input_prims=rep.distribution.choice(cubes, num_samples=0))
