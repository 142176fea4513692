"""What sensors, extensions and writers of scripts build on."""

import importlib
import sys

import numpy as np
import pytest
from pxr import UsdGeom

import usdsdg as rep
from usdsdg.compat import finder
from usdsdg.compat.isaacsim.core.api import World
from usdsdg.compat.isaacsim.core.api.sensors import BaseSensor
from usdsdg.compat.isaacsim.core.utils import extensions
from usdsdg.compat.isaacsim.sensors.camera import Camera
from usdsdg.errors import Unsupported


@pytest.fixture
def world(stage):
    World.clear_instance()
    yield World()
    World.clear_instance()


class Barometer(BaseSensor):
    """A sensor that reads its own height."""

    def __init__(self, prim_path, name="barometer", water=0.0, **pose):
        super().__init__(prim_path, name=name, **pose)
        self._water, self.initialized = water, 0

    def initialize(self, physics_sim_view=None):
        super().initialize(physics_sim_view)
        self.initialized += 1

    def pressure(self):
        return self._water - self.get_world_pose()[0][2]


def test_a_sensor_of_a_script_has_a_pose_and_is_reset_with_its_scene(stage, world):
    UsdGeom.Xform.Define(stage, "/World/robot").AddTranslateOp().Set((0, 0, 2))
    sensor = world.scene.add(Barometer("/World/robot/sensor", water=10.0, translation=np.array([0, 0, 1.0])))
    world.reset()
    assert sensor.initialized == 1
    assert sensor.pressure() == pytest.approx(10 - 3)
    sensor.set_world_pose(position=np.array([0, 0, 5.0]))
    assert sensor.pressure() == pytest.approx(5)
    world.reset()
    assert sensor.pressure() == pytest.approx(7), "the default pose comes back"


def test_the_path_of_a_scripts_own_extension_is_the_folder_of_its_package(tmp_path, monkeypatch):
    (tmp_path / "omni" / "acme").mkdir(parents=True)
    (tmp_path / "omni" / "acme" / "tools.py").write_text("size = 3")
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])
    assert extensions.get_extension_path_from_name("omni.acme") == str(tmp_path)
    assert extensions.get_extension_path("omni.acme-1.2.0") == str(tmp_path)
    with pytest.raises(Unsupported, match=r"holds a package 'omni\.importer\.urdf'"):
        extensions.get_extension_path_from_name("omni.importer.urdf")


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [((10, 10), (30, 20), 0.0), ((-10, 10), (10, 20), 0.5), ((90, 40), (110, 60), 0.75), ((200, 0), (210, 9), 1.0)],
)
def test_a_box_is_truncated_by_the_part_of_its_rectangle_outside_the_image(low, high, expected):
    finder.install()
    utils = importlib.import_module("isaacsim.replicator.writers.scripts.utils")
    corners = [low, high, (low[0], high[1]), (high[0], low[1])]
    assert utils.calculate_truncation_ratio_simple(np.array(corners), 100, 50) == pytest.approx(expected)


def test_a_soft_reset_does_not_initialize_again(world):
    sensor = world.scene.add(Barometer("/World/sensor"))
    world.reset()
    world.reset(soft=True)
    assert sensor.initialized == 1
    world.reset()
    assert sensor.initialized == 2


class OwnCamera(Camera):
    """A camera with attributes that ours must not take for its own."""

    def __init__(self, prim_path, **given):
        super().__init__(prim_path, **given)
        self._device = object()


def test_a_camera_in_a_scene_is_initialized_once_also_where_a_script_does_it_too(stage, world):
    camera = world.scene.add(OwnCamera("/World/camera", resolution=(16, 8)))
    assert camera.get_render_product_path() is None
    world.reset()
    product = camera.get_render_product_path()
    assert product is not None
    camera.initialize()
    world.reset()
    assert camera.get_render_product_path() == product
    assert [prim.GetName() for prim in stage.Traverse() if prim.GetTypeName() == "RenderProduct"] == [
        product.rsplit("/", 1)[-1]
    ]


def test_a_world_can_be_reset_before_the_first_update_of_a_camera(world):
    camera = Camera("/World/camera", resolution=(16, 8))
    world.reset()
    camera.initialize()
    world.reset()
    world.step()
    assert np.shape(camera.get_rgba()) == (8, 16, 4)
    assert camera.get_current_frame()["rendering_time"] > 0


def test_a_camera_of_an_earlier_stage_ends_without_the_images_of_its_successor(stage, world):
    earlier = Camera("/World/camera", resolution=(16, 8))
    earlier.initialize()
    rep.new_stage()
    camera = Camera("/World/camera", resolution=(16, 8))
    camera.initialize()
    earlier.destroy()
    world.step()
    assert np.shape(camera.get_rgba()) == (8, 16, 4)
