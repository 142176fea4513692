"""Nodes of the randomization graph by OmniGraph's names: scripts list them, find them by path, and set their inputs."""

import pytest
from pxr import Gf

import usdsdg as rep
from usdsdg.compat.omni.graph import core as og
from usdsdg.errors import Unsupported

PIPELINE = "/Replicator/SDGPipeline"


@pytest.fixture
def cube(stage):
    cube = rep.create.cube()
    with rep.trigger.on_custom_event("go"), cube:
        rep.modify.pose(position=rep.distribution.uniform((0, 0, 0), (1, 1, 1)))
    return stage.GetPrimAtPath(cube.prims[0])


def position(cube):
    rep.utils.send_og_event("go")
    og.Controller.evaluate_sync(rep.utils.get_graph())
    return tuple(cube.GetAttribute("xformOp:translate").Get())


def test_nodes_of_the_graph_are_listed(cube):
    graph = rep.utils.get_graph()
    types = [node.get_type_name() for node in graph.get_nodes()]
    assert types == [
        "omni.graph.action.OnCustomEvent",
        "omni.replicator.core.OgnSampleUniform",
        "omni.replicator.core.OgnWritePose",
    ]
    assert [node.get_node_type().get_node_type() for node in graph.get_nodes()] == types
    assert all(node.is_valid() and node.get_graph() is graph for node in graph.get_nodes())
    assert og.Controller.graph(PIPELINE) is og.get_graph_by_path(graph.get_path_to_graph()) is graph
    event = og.AttributeValueHelper(graph.get_nodes()[0].get_attribute("inputs:eventName"))
    assert event.get() == "go"
    rep.new_stage()
    assert not graph.get_nodes()
    assert not graph.is_valid()


@pytest.mark.parametrize("how", ["path", "node", "controller", "helper", "edit", "by_name", "pxr"])
def test_inputs_are_set_however_they_are_found(cube, how):
    path, name = f"{PIPELINE}/OgnSampleUniform", "inputs:lower"
    node = og.Controller().node(path)
    assert og.get_node_by_path(path) is node is og.Controller.node("OgnSampleUniform", rep.utils.get_graph())
    match how:
        case "path":
            og.Controller.attribute(f"{path}.{name}").set((1, 1, 1))
        case "node":
            node.get_attribute(name).set((1, 1, 1))
        case "controller":
            og.Controller.set(og.Controller.attribute(name, node), (1, 1, 1))
        case "helper":
            og.AttributeValueHelper(node.get_attribute(name)).set((1, 1, 1))
        case "edit":
            og.Controller.edit(PIPELINE, {og.Controller.Keys.SET_VALUES: [(f"OgnSampleUniform.{name}", (1, 1, 1))]})
        case "by_name":
            og.Controller.set((name, node), (1, 1, 1))
        case "pxr":
            rep.get_stage().GetPrimAtPath(path).GetAttribute(name).Set(Gf.Vec3i(1, 1, 1))
    assert position(cube) == (1, 1, 1)
    assert list(og.Controller.get(f"{path}.outputs:samples")[0]) == [1, 1, 1]


def test_what_is_not_there_is_named(cube):
    node = og.Controller.node(f"{PIPELINE}/OgnWritePose")
    assert [path.GetString() for path in node.get_attribute("outputs:prims").get()] == [str(cube.GetPath())]
    with pytest.raises(og.OmniGraphError, match=r"no node /Replicator/SDGPipeline/OgnGroup"):
        og.Controller.node(f"{PIPELINE}/OgnGroup")
    with pytest.raises(og.OmniGraphError, match=r"no attribute 'inputs:color'; there are: .*inputs:position"):
        og.Controller.attribute("inputs:color", node)
    with pytest.raises(Unsupported, match="made by functions of rep"):
        og.Controller.create_node(("a", PIPELINE), "omni.replicator.core.OgnSampleUniform")
    with pytest.raises(Unsupported, match="made by functions of rep"):
        og.Controller.edit(PIPELINE, {og.Controller.Keys.CREATE_NODES: [("a", "OgnSampleUniform")]})


def test_connections_lead_from_node_to_node(stage):
    cube, draws = rep.create.cube(), rep.distribution.uniform((0, 0, 0), (1, 1, 1))
    with rep.trigger.on_frame() as trigger, cube:
        pose = rep.modify.pose(position=draws)
        turned = rep.randomizer.rotation()
    [before] = turned.node.get_attribute("inputs:execIn").get_upstream_connections()
    assert (before.get_node(), before.get_name()) == (pose.node, "outputs:execOut")
    [first] = trigger.node.get_attribute("outputs:execOut").get_downstream_connections()
    assert (first.get_node(), first.get_name()) == (pose.node, "inputs:execIn")
    [drawn] = pose.node.get_attribute("inputs:position").get_upstream_connections()
    assert (drawn.get_node(), drawn.get_name()) == (draws.node, "outputs:samples")
    assert turned.node.get_attribute("outputs:execOut").get_downstream_connection_count() == 0
    assert trigger.node.get_attribute("inputs:interval").get_upstream_connection_count() == 0


def test_what_runs_once_is_connected_to_no_node(stage):
    with rep.create.cube():
        once = rep.modify.pose(position=rep.distribution.uniform((0, 0, 0), (1, 1, 1)))
    assert once.node.get_attribute("inputs:execIn").get_upstream_connections() == []
