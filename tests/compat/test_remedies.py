"""Errors for names of Isaac Sim that usdsdg lacks name a remedy; small names that were added work."""

import importlib

import pytest
from pxr import Gf, UsdGeom, UsdPhysics

import usdsdg
from usdsdg.compat import carb, finder
from usdsdg.compat.isaacsim.core.utils import semantics
from usdsdg.compat.omni.graph import core as og
from usdsdg.compat.omni.isaac.kit.utils import set_carb_setting
from usdsdg.compat.omni.kit import commands
from usdsdg.errors import BadPrim, Unsupported
from usdsdg.session.settings.store import get_settings
from usdsdg.session.stage_context import current_stage, new_stage


@pytest.fixture(autouse=True)
def _empty_stage():
    new_stage()
    finder.install()


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("omni.isaac.core.utils.torch", "rotations of NumPy arrays"),
        ("isaacsim.core.utils.warp", "rotations of NumPy arrays"),
        ("omni.renderer_capture", "capture_viewport_to_file"),
        ("omni.hydratexture", "create.render_product"),
        ("omni.physxcommands", "omni.kit.commands.execute"),
        ("omni.stageupdate", "get_update_event_stream"),
        ("omni.syntheticdata.generic_helper_lib", "omni.syntheticdata.helpers"),
    ],
)
def test_a_module_that_is_elsewhere_says_where(name, told):
    with pytest.raises(ModuleNotFoundError, match="elsewhere") as caught:
        importlib.import_module(name)
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("module", "name", "told"),
    [
        ("carb", "get_framework", "carb.settings.get_settings"),
        ("carb", "log_warning", "carb.log_warn"),
        ("omni.client", "set_alias", "--map PREFIX=FOLDER"),
        ("omni.replicator.core.utils.viewport_manager", "ViewportManager", "create.render_product"),
    ],
)
def test_a_name_that_is_elsewhere_says_where(module, name, told):
    with pytest.raises(AttributeError, match="elsewhere") as caught:
        getattr(importlib.import_module(module), name)
    assert told in str(caught.value)


def test_nodes_of_scripts_are_read_and_refused_when_they_are_registered():
    graphs = importlib.import_module("omni.graph.core")
    tools = importlib.import_module("omni.graph.tools.ogn")
    assert graphs.Database.ROLE_EXECUTION
    assert tools.MetadataKeys.DEFAULT
    assert graphs.ExecutionAttributeState.ENABLED
    with pytest.raises(Unsupported, match=r"rep\.randomizer\.register"):
        graphs.register_node_type(object, 1)


def test_a_node_is_created_by_its_path_or_in_a_graph():
    kind = "omni.graph.nodes.GpuInteropRenderProductEntry"
    assert kind in og.get_registered_nodes()
    graph = og.post_render_graph("/Render/Product")
    assert og.Controller.create_node(("entry", graph), kind).get_prim_path() == f"{graph.path}/entry"
    assert og.Controller.create_node(f"{graph.path}/other", kind) is graph.get_node("other")
    with pytest.raises(Unsupported, match=r"OnTick.*rep\.randomizer\.register"):
        og.Controller.create_node("/World/Graph/tick", "omni.graph.action.OnTick")


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("IsaacSensorCreateRtxLidar", "lidar, radar, ultrasonic and effort sensors are out of scope"),
        ("RangeSensorCreateLidar", "The annotator `pointcloud` of a camera"),
        ("URDFParseAndImportFile", "Convert the asset to USD"),
        ("CreatePrmWithDefaultXform", "did you mean CreatePrimWithDefaultXform"),
    ],
)
def test_a_command_out_of_scope_says_what_to_do(name, told):
    with pytest.raises(Unsupported, match=r"omni\.kit\.commands") as caught:
        commands.execute(name, path="/World/It")
    assert told in str(caught.value)


def test_labels_of_what_is_no_prim_say_how_to_get_one():
    with pytest.raises(BadPrim, match=r"pass stage\.GetPrimAtPath\('/World/Box'\)"):
        semantics.add_update_semantics("/World/Box", "box")
    with pytest.raises(BadPrim, match="nothing at the path that the script asked for"):
        semantics.add_labels(current_stage().GetPrimAtPath("/World/Box"), ["box"])


def test_cameras_that_a_render_product_may_have_are_named_as_they_are():
    UsdGeom.Camera.Define(current_stage(), "/World/Eye")
    with pytest.raises(BadPrim, match=r"give at least one\. Cameras on the stage: .*/World/Eye"):
        usdsdg.create.render_product(None, (64, 48))


def test_labels_by_the_inner_function_of_replicator():
    box = UsdGeom.Cube.Define(current_stage(), "/World/Box").GetPrim()
    usdsdg.utils._set_semantics_legacy(box, [("class", "box")])
    assert semantics.get_labels(box) == {"class": ["box"]}


def test_the_orientation_of_a_motion_sensor_may_be_numbers():
    UsdPhysics.RigidBodyAPI.Apply(UsdGeom.Cube.Define(current_stage(), "/World/Box").GetPrim())
    _, sensor = commands.execute(
        "IsaacSensorCreateImuSensor", path="/Imu", parent="/World/Box", orientation=(0.0, 1.0, 0.0, 0.0)
    )
    assert sensor.GetAttribute("xformOp:orient").Get() == Gf.Quatd(0, 1, 0, 0)


def test_colors_and_settings_of_earlier_scripts():
    assert carb.ColorRgba(1, 0.5, 0, 0.25).a == 0.25
    assert carb.ColorRgb(1, 0.5, 0).g == 0.5
    set_carb_setting(get_settings(), "/mine/value", 3)
    assert get_settings().get("/mine/value") == 3
