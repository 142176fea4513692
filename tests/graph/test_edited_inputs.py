"""Nodes take over what a script edits at their prims with pxr while it runs."""

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

import usdsdg as rep
from usdsdg.errors import GraphError
from usdsdg.graph.evaluate import graph
from usdsdg.graph.worlds import WorldDraws


@pytest.fixture
def cubes(stage):
    return rep.create.cube(count=2)


def prim(item) -> Usd.Prim:
    return rep.get_stage().GetPrimAtPath(item.node.get_prim_path())


def positions(cubes):
    xforms = map(UsdGeom.Xformable, cubes.get_output_prims()["prims"])
    return [xform.GetLocalTransformation().ExtractTranslation()[0] for xform in xforms]


def test_bounds_that_are_edited_are_drawn_from(cubes):
    draws = rep.distribution.uniform((0.0, 0, 0), (1.0, 1, 1))
    with rep.trigger.on_frame(), cubes:
        rep.modify.pose(position=draws)
    rep.orchestrator.step()
    assert all(0 <= x <= 1 for x in positions(cubes))

    prim(draws).GetAttribute("inputs:lower").Set(Gf.Vec3d(70, 0, 0))
    prim(draws).GetAttribute("inputs:upper").Set(Gf.Vec3d(71, 1, 1))
    rep.orchestrator.step()
    assert all(70 <= x <= 71 for x in positions(cubes))
    assert draws.get_input("lower") == (70, 0, 0)


def test_an_input_that_the_node_was_not_given_can_be_authored(cubes):
    draws = rep.distribution.uniform((0, 0, 0), (1, 1, 1))
    with rep.trigger.on_frame(), cubes:
        rep.modify.pose(position=draws)
    prim(draws).CreateAttribute("inputs:seed", Sdf.ValueTypeNames.Int).Set(5)
    prim(draws).CreateAttribute("inputs:of_somebody", Sdf.ValueTypeNames.Int).Set(5)
    rep.orchestrator.step()
    assert draws.get_inputs() == {"lower": (0, 0, 0), "upper": (1, 1, 1), "seed": 5}


def test_choices_targets_and_limits_can_be_edited(cubes):
    choices = rep.distribution.choice([(1.0, 0, 0), (2.0, 0, 0)])
    with rep.trigger.on_frame(max_execs=9) as trigger, cubes:
        pose = rep.modify.pose(position=choices)
    rep.orchestrator.step()
    before = positions(cubes)

    prim(choices).GetAttribute("inputs:choices").Set([(5, 0, 0)])
    prim(pose).GetRelationship("inputs:prims").SetTargets([cubes.prims[1]])
    rep.orchestrator.step()
    assert positions(cubes) == [before[0], 5]

    prim(trigger).GetAttribute("inputs:maxExecs").Set(2)
    prim(choices).GetAttribute("inputs:choices").Set([(6, 0, 0)])
    rep.orchestrator.step()
    assert positions(cubes) == [before[0], 5]


def test_a_value_that_a_node_cannot_have_is_refused_by_its_line(cubes):
    draws = rep.distribution.uniform((0.0, 0, 0), (1.0, 1, 1))
    with rep.trigger.on_frame(), cubes:
        rep.modify.pose(position=draws)
    prim(draws).GetAttribute("inputs:lower").Set(Gf.Vec3d(2, 0, 0))
    with pytest.raises(GraphError, match=r"test_edited_inputs\.py:.*is above upper"):
        rep.orchestrator.step()


def test_what_the_graph_itself_authors_is_no_edit(cubes):
    draws = rep.distribution.uniform((0.0, 0, 0), (1.0, 1, 1))
    with rep.trigger.on_frame(), cubes:
        rep.modify.pose(position=draws)
    draws.set_input("upper", (2, 2, 2))
    cubes.get_output_prims()["prims"][0].CreateAttribute("inputs:lower", Sdf.ValueTypeNames.Int)
    assert graph().edits.take() == []
    prim(draws).GetAttribute("inputs:lower").Set(Gf.Vec3d(0.5, 0, 0))
    assert [path.name for path in graph().edits.take()] == ["inputs:lower"]


def test_frames_that_are_drawn_together_have_the_edits(cubes):
    draws = rep.distribution.uniform((0.0, 0, 0), (1.0, 1, 1))
    with rep.trigger.on_frame(), cubes:
        rep.modify.pose(position=draws)
    rep.orchestrator.step()
    prim(draws).GetAttribute("inputs:upper").Set(Gf.Vec3d(71, 1, 1))
    prim(draws).GetAttribute("inputs:lower").Set(Gf.Vec3d(70, 0, 0))
    values = WorldDraws(graph(), 1, 3).values()
    drawn = [column for columns in values.values.values() for column in columns.values()]
    assert drawn
    assert all(70 <= x <= 71 for column in drawn for x in column[:, 0])
