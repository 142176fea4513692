"""Names that scripts find in modules of Isaac Sim: those that the modules import, and small modules of their own."""

import importlib
import json

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.annotators import named_annotators
from usdsdg.compat import finder, imported_names
from usdsdg.compat.isaacsim.core.api import World
from usdsdg.compat.isaacsim.core.api.loggers import DataLogger
from usdsdg.compat.isaacsim.core.experimental.utils import app, backend, foundation
from usdsdg.compat.isaacsim.core.utils import interops
from usdsdg.compat.isaacsim.sensors.camera import SingleViewDepthSensorAsset
from usdsdg.compat.isaacsim.storage import native
from usdsdg.errors import ArgumentError, Unsupported, UsdsdgWarning
from usdsdg.session.stage_context import current_stage, new_stage


@pytest.fixture(autouse=True)
def _empty_stage():
    new_stage()
    finder.install()


@pytest.mark.parametrize("module", imported_names.importers())
def test_names_that_a_module_imports_in_isaac_sim_are_found_in_it(module):
    found = importlib.import_module(module)
    for name in imported_names.imported_by(module):
        place, original = imported_names.place_of(finder.real_name(module), name)
        assert getattr(found, name) is getattr(importlib.import_module(place), original), name


def test_names_of_other_modules_are_not_found_in_one_that_does_not_import_them():
    with pytest.raises(AttributeError, match="has no 'get_current_stage'"):
        importlib.import_module("isaacsim.core.utils.string").get_current_stage  # noqa: B018


def test_old_functions_of_the_assets_root_stand_for_servers(tmp_path, monkeypatch):
    (tmp_path / "Isaac" / "Props").mkdir(parents=True)
    (tmp_path / "Isaac" / "Props" / "a.usda").write_text("#usda 1.0\n")
    (tmp_path / "Isaac" / "b.png").write_bytes(b"x")
    monkeypatch.setenv("USDSDG_ASSETS_ROOT", str(tmp_path))
    root = native.get_assets_root_path()
    assert native.get_isaac_asset_root_path() == f"{root}/Isaac"
    assert native.get_server_path("/Isaac/Props") == root
    assert native.check_server(root, "/Isaac/b.png")
    assert not native.check_server(root, "/None")
    assert native.get_full_asset_path("/Isaac/b.png") == f"{root}/Isaac/b.png"
    assert native.get_full_asset_path("/Isaac/c.png") is None
    assert native.list_folder(f"{root}/Isaac") == ([f"{root}/Isaac/b.png"], [f"{root}/Isaac/Props/"])
    assert native.recursive_list_folder(f"{root}/Isaac") == [f"{root}/Isaac/b.png", f"{root}/Isaac/Props/a.usda"]
    assert native.get_url_root("omniverse://localhost/NVIDIA/Assets") == "omniverse://localhost"
    with pytest.raises(RuntimeError, match="/None; --assets-root names another"):
        native.get_server_path("/None")


def test_a_world_logs_what_a_function_measures_at_each_step(tmp_path):
    world = World()
    logger = world.get_data_logger()
    logger.start()
    with pytest.raises(RuntimeError, match="add_data_frame_logging_func"):
        world.step(render=False)
    logger.add_data_frame_logging_func(lambda scene, tasks: {"time": world.current_time, "tasks": len(tasks)})
    logger.reset()
    world.reset()
    world.step(render=False)
    assert logger.get_num_of_data_frames() == 0  # paused
    logger.start()
    for _ in range(3):
        world.step(render=False)
    logger.save(str(tmp_path / "log.json"))
    assert len(json.loads((tmp_path / "log.json").read_text())["Isaac Sim Data"]) == 3
    read = DataLogger()
    read.load(str(tmp_path / "log.json"))
    assert read.get_data_frame(2).data == {"time": pytest.approx(world.current_time), "tasks": 0}
    assert read.get_data_frame(2).current_time_step == world.current_time_step_index
    World.clear_instance()


def test_arrays_go_from_one_library_to_another():
    numbers = np.arange(6, dtype=np.float32).reshape(2, 3)
    assert np.array_equal(interops.warp2numpy(interops.numpy2warp(numbers)), numbers)
    assert len(interops.__all__) == 20
    with pytest.raises(Unsupported, match="numpy2tensorflow: tensorflow is not installed"):
        interops.numpy2tensorflow(numbers)


def test_types_of_attributes_by_their_names():
    assert foundation.resolve_value_type_name("color3f[]", backend="usdrt") == Sdf.ValueTypeNames.Color3fArray
    assert foundation.value_type_name_to_str(Sdf.ValueTypeNames.Matrix4d) == "matrix4d"
    assert "asset" in foundation.get_value_type_names()
    with pytest.raises(ValueError, match="did you mean color3f"):
        foundation.resolve_value_type_name("colour3f")
    with pytest.raises(ValueError, match="backend is 'tensor'"):
        foundation.resolve_value_type_name("float", backend="tensor")
    with backend.use_backend("simstate"):
        assert backend.get_simstate_mode() is backend.SimStateMode.DISABLED
    assert app.get_extension_dict("isaacsim.core.utils") is None


def test_sensors_of_an_asset_measure_as_their_templates_say(tmp_path):
    asset = Usd.Stage.CreateNew(str(tmp_path / "sensor.usda"))
    UsdGeom.Xform.Define(asset, "/Sensor")
    UsdGeom.Camera.Define(asset, "/Sensor/Eye")
    asset.SetDefaultPrim(asset.GetPrimAtPath("/Sensor"))
    template = asset.DefinePrim("/Sensor/Eye_product", "RenderProduct")
    template.ApplyAPI("OmniSensorDepthSensorSingleViewAPI")
    template.CreateRelationship("camera").SetTargets(["/Sensor/Eye"])
    template.CreateAttribute("resolution", Sdf.ValueTypeNames.Int2).Set(Gf.Vec2i(32, 24))
    template.CreateAttribute("omni:rtx:post:depthSensor:baselineMM", Sdf.ValueTypeNames.Float).Set(40.0)
    asset.Save()
    UsdGeom.Cube.Define(current_stage(), "/World/Box")
    made = SingleViewDepthSensorAsset("/World/Depth", str(tmp_path / "sensor.usda"), position=(-4, 0, 0))
    assert made.get_all_depth_sensor_paths() == ["/World/Depth/Eye"]
    made.initialize()
    sensor = made.get_child_depth_sensor("/World/Depth/Eye")
    assert (sensor.get_baseline_mm(), sensor.get_enabled(), sensor.get_resolution()) == (40.0, True, (32, 24))
    assert named_annotators.get("DepthSensorDistance")
    with pytest.raises(KeyError, match="the asset's are /World/Depth/Eye"):
        made.get_child_depth_sensor("/World/Other")
    added = SingleViewDepthSensorAsset.add_template_render_product("/World", "/World/Depth/Eye")
    assert added.GetPath() == "/World/Eye_render_product"
    with pytest.raises(ArgumentError, match="is a Cube, no Camera"):
        SingleViewDepthSensorAsset.add_template_render_product("/World", "/World/Box")
    empty = Usd.Stage.CreateNew(str(tmp_path / "none.usda"))
    empty.SetDefaultPrim(empty.DefinePrim("/None"))
    empty.Save()
    with pytest.warns(UsdsdgWarning, match="so no depth sensor"):
        SingleViewDepthSensorAsset("/World/None", str(tmp_path / "none.usda"))
