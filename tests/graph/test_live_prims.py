"""`rep.get` with `cache_result=False`: prims are searched again at each execution of what acts on them."""

import pytest

import usdsdg as rep
from usdsdg import get
from usdsdg.app import saved_graph
from usdsdg.errors import Unsupported, UsdsdgWarning
from usdsdg.graph import evaluate
from usdsdg.graph.worlds import WorldDraws
from usdsdg.session.stage_context import current_stage, new_stage, open_stage


def crate(stage, name):
    return stage.DefinePrim(f"/World/{name}", "Cube")


def sizes(stage):
    return [prim.GetAttribute("size").Get() for prim in stage.GetPrimAtPath("/World").GetChildren()]


def test_prims_are_searched_again_at_each_execution(stage):
    crate(stage, "crate_0")
    with rep.trigger.on_frame(), get.prims(path_pattern="/World/crate", cache_result=False):
        rep.modify.attribute("size", rep.distribution.sequence([3.0, 4.0], stride=1))
    with rep.trigger.on_frame(), get.prims(path_pattern="/World/crate"):
        rep.modify.attribute("purpose", "render")
    rep.orchestrator.step()
    assert sizes(stage) == [3.0]
    late = crate(stage, "crate_1")
    rep.orchestrator.step()
    assert len(sizes(stage)) == 2
    assert set(sizes(stage)) <= {3.0, 4.0}
    assert late.GetAttribute("purpose").Get() == "default"


def test_the_earlier_name_of_cache_result_is_taken(stage):
    crate(stage, "crate_0")
    with rep.trigger.on_frame(), get.prims(path_pattern="/World/crate", cache_prims=False):
        rep.modify.attribute("size", 3.0)
    crate(stage, "crate_1")
    rep.orchestrator.step()
    assert sizes(stage) == [3.0, 3.0]
    assert len(get.prims(path_pattern="/World/crate", cache_prims=True).get_output_prims()["prims"]) == 2


def test_prims_that_are_gone_are_no_error(stage):
    crate(stage, "crate_0")
    crate(stage, "crate_1")
    with rep.trigger.on_frame(), get.prims(path_pattern="/World/crate", cache_result=False):
        rep.randomizer.color(colors=rep.distribution.uniform((0, 0, 0), (1, 1, 1)))
        rep.modify.attribute("size", 3.0)
    rep.orchestrator.step()
    stage.RemovePrim("/World/crate_0")
    rep.orchestrator.step()
    assert sizes(stage) == [3.0]


def test_a_search_may_find_nothing_for_a_while(stage):
    found = get.shape(path_match="crate", cache_result=False)
    with rep.trigger.on_frame(), found:
        rep.modify.attribute("size", 7.0)
    rep.orchestrator.step()
    assert found.get_output("prims") == []
    crate(stage, "crate")
    rep.orchestrator.step()
    assert sizes(stage) == [7.0]
    assert found.get_output("prims") == ["/World/crate"]


def test_labels_decide_anew_and_groups_search_again_too(stage):
    first, second = crate(stage, "a"), crate(stage, "b")
    group = rep.create.group(["/World/a", get.prims(semantics=[("class", "big")], cache_result=False)])
    with rep.trigger.on_frame(), group:
        rep.modify.attribute("size", 5.0)
    rep.orchestrator.step()
    assert sizes(stage) == [5.0, 2.0]
    rep.functional.modify.semantics(second, {"class": "big"})
    rep.orchestrator.step()
    assert sizes(stage) == [5.0, 5.0]
    assert group.get_output_prims()["prims"] == [first, second]


def test_draws_of_a_prim_do_not_depend_on_what_else_is_found(stage):
    def drawn(names):
        rep.set_global_seed(5)
        new_stage()
        for name in names:
            crate(current_stage(), name)
        with rep.trigger.on_frame(), get.prims(path_match="crate", cache_result=False):
            rep.modify.attribute("size", rep.distribution.uniform(1.0, 9.0))
        rep.orchestrator.step()
        return current_stage().GetPrimAtPath("/World/crate_1").GetAttribute("size").Get()

    # A search is keyed by itself, not by what it finds when its line runs.
    assert drawn(["crate_1"]) == drawn(["crate_0", "crate_1"])


def test_a_saved_graph_searches_again_too(stage, tmp_path):
    with rep.trigger.on_frame(), get.prims(path_pattern="crate", prim_types=["Cube"], cache_result=False):
        rep.modify.attribute("size", 7.0)
    rep.orchestrator.step()
    stage.Export(str(tmp_path / "saved.usda"))
    open_stage(str(tmp_path / "saved.usda"))
    saved_graph.load(current_stage())
    crate(current_stage(), "crate")
    rep.orchestrator.step()
    assert sizes(current_stage()) == [7.0]


def test_as_an_argument_the_prims_are_those_of_the_line_and_it_says_so(stage):
    crate(stage, "crate")
    ball = rep.create.sphere(position=(3, 0, 0))
    with ball, pytest.warns(UsdsdgWarning, match="as an argument"):
        rep.modify.pose(look_at=get.prims(path_match="crate", cache_result=False))


def drawn_worlds(stage, **conditions):
    for index in range(2):
        rep.functional.modify.semantics(crate(stage, f"crate_{index}"), {"class": "crate"})
    with rep.trigger.on_frame(), get.prims(**conditions, cache_result=False):
        rep.modify.attribute("size", rep.distribution.uniform(1.0, 2.0))
    rep.orchestrator.step()
    return WorldDraws(evaluate.graph(), 1, 3).values()


def test_worlds_search_by_paths(stage):
    assert drawn_worlds(stage, path_match="crate")


def test_worlds_refuse_searches_by_labels(stage):
    with pytest.raises(Unsupported, match="by labels"):
        drawn_worlds(stage, semantics=[("class", "crate")])
