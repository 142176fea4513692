"""`omni.graph.core.Controller`: randomizers run at once, camera nodes process a render product, others are refused."""

import numpy as np
import pytest
from pxr import UsdGeom, UsdLux

import usdsdg as rep
from usdsdg.app.app import get_app
from usdsdg.compat.omni.graph import core as og
from usdsdg.compat.omni.syntheticdata.synthetic_data import SyntheticData, SyntheticDataStage
from usdsdg.errors import Unsupported

CAMERA = "omni.sensors.nv.camera"


@pytest.fixture
def graph(stage):
    UsdLux.DomeLight.Define(stage, "/World/sky")
    product = rep.create.render_product(rep.create.camera(position=(0, 0, 9), look_at=(0, 0, 0)), (8, 6))
    data = SyntheticData.Get()
    return data.get_graph(SyntheticDataStage.POST_RENDER, product.path).get_wrapped_graph()


def built(graph, folder, *, only_last=False):
    keys = og.Controller.Keys
    return og.Controller.edit(
        graph,
        {
            keys.CREATE_NODES: [
                ("Tex", f"{CAMERA}.CamTextureReadTaskNode"),
                ("Write", f"{CAMERA}.CamFileWriterTaskNode"),
            ],
            keys.CONNECT: [("Tex.outputs:rp", "Write.inputs:rp"), ("Tex.outputs:dest", "Write.inputs:src")],
            keys.SET_VALUES: [
                ("Tex.inputs:aov", "HDR"),
                ("Write.inputs:filename", str(folder / "hdr..bin")),
                ("Write.inputs:eachFrameOneFile", True),
                ("Write.inputs:onlyLastFrame", only_last),
            ],
        },
    )


def test_randomizers_run_at_once(stage):
    cube = rep.create.cube()
    with rep.trigger.on_custom_event("go"), cube:
        rep.modify.pose(position=(1, 2, 3))
    rep.utils.send_og_event("go")
    og.Controller.evaluate_sync()
    assert UsdGeom.Xformable(stage.GetPrimAtPath(cube.prims[0])).ComputeLocalToWorldTransform(0)[3][1] == 2


def test_camera_nodes_write_a_file_at_every_update(graph, tmp_path):
    built(graph, tmp_path)
    get_app().update()
    get_app().update()
    assert sorted(file.name for file in tmp_path.iterdir()) == ["hdr.0.bin", "hdr.1.bin"]
    pixels = np.frombuffer((tmp_path / "hdr.0.bin").read_bytes(), np.float16)
    assert pixels.size == 6 * 8 * 4


def test_only_the_last_frame_is_kept(graph, tmp_path):
    built(graph, tmp_path, only_last=True)
    get_app().update()
    get_app().update()
    assert [file.name for file in tmp_path.iterdir()] == ["hdr.0.bin"]


def test_inputs_are_read_and_set_by_path(graph, tmp_path):
    _, nodes, _, by_name = built(graph, tmp_path)
    assert nodes == list(by_name.values())
    attribute = og.Controller.attribute(f"{graph.path}/Tex.inputs:aov")
    assert attribute.get() == "HDR"
    og.Controller.set(("inputs:aov", nodes[0]), "LDR")
    assert og.Controller.get(attribute) == "LDR"


def test_attributes_of_prims_are_read_and_set(stage):
    UsdGeom.Cube.Define(stage, "/World/cube")
    attribute = og.Controller.attribute("/World/cube.size")
    assert attribute.get() == 2.0
    assert attribute.set(3.0)
    assert stage.GetPrimAtPath("/World/cube").GetAttribute("size").Get() == 3.0


def test_other_node_types_are_refused_by_name(stage):
    with pytest.raises(Unsupported, match="OnPlaybackTick"):
        og.Controller.edit(
            {"graph_path": "/ActionGraph", "evaluator_name": "execution"},
            {og.Controller.Keys.CREATE_NODES: [("tick", "omni.graph.action.OnPlaybackTick")]},
        )


def test_an_unknown_input_is_refused_with_the_known_ones(graph, tmp_path):
    built(graph, tmp_path)
    with pytest.raises(og.OmniGraphError, match="inputs:filename"):
        og.Controller.attribute(f"{graph.path}/Write.inputs:file")


def test_a_new_stage_forgets_graphs(graph, tmp_path):
    from usdsdg.session.stage_context import new_stage

    built(graph, tmp_path)
    new_stage()
    get_app().update()
    assert og.get_all_graphs() == []
    assert not list(tmp_path.iterdir())
