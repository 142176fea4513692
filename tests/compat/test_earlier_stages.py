"""What a script keeps of an earlier stage or session leaves the current one as it is."""

import gc

import pytest

import usdsdg as rep
from usdsdg.app.app import get_app
from usdsdg.compat.isaacsim.core.api import World
from usdsdg.compat.isaacsim.sensors.camera import Camera, CameraView
from usdsdg.compat.omni.kit.viewport.utility import create_viewport_window, get_active_viewport
from usdsdg.compat.omni.syntheticdata.synthetic_data import SyntheticData
from usdsdg.session import session, stage_context
from usdsdg.session.render_products import product_at
from usdsdg.session.timeline import get_timeline

PERSPECTIVE = "/OmniverseKit_Persp"


@pytest.fixture(autouse=True)
def _first_stage(stage):
    _scene()


def _scene():
    rep.create.light(light_type="dome")
    rep.create.cube()


def _next_stage():
    stage_context.new_stage()
    _scene()


def _product(size):
    return rep.create.render_product(rep.create.camera(position=(5, 0, 0), look_at=(0, 0, 0)), size)


def _update(count):
    for _ in range(count):
        get_app().update()


def test_the_viewport_does_not_take_the_product_at_the_path_of_its_own():
    viewport = get_active_viewport()
    viewport.render_product_path = _product((64, 48)).path
    _next_stage()
    product = _product((32, 16))
    camera = product.camera_path
    viewport.resolution = 640, 480
    viewport.set_active_camera(PERSPECTIVE)
    viewport.updates_enabled = False
    assert (product.resolution, product.camera_path, product.updates_enabled) == ((32, 16), camera, True)
    assert viewport.render_product_path != product.path


def test_two_viewports_have_two_products_on_every_stage():
    viewport = get_active_viewport()
    _ = viewport.render_product_path
    _next_stage()
    other = create_viewport_window(width=64, height=48).viewport_api
    assert other.render_product_path != viewport.render_product_path
    assert product_at(other.render_product_path).resolution == (64, 48)


def test_the_viewport_looks_through_the_camera_that_every_stage_has():
    viewport = get_active_viewport()
    viewport.set_active_camera(_product((8, 8)).camera_path)
    _next_stage()
    assert str(viewport.camera_path) == PERSPECTIVE
    assert product_at(viewport.render_product_path).camera_path == PERSPECTIVE


@pytest.mark.parametrize("frequency", [None, 20], ids=["every update", "some updates"])
def test_a_camera_that_is_kept_lets_the_next_stage_be_updated(frequency):
    kept = []
    for _ in range(2):
        _next_stage()
        camera = Camera("/World/Camera", position=(5, 0, 0), resolution=(16, 16), frequency=frequency)
        camera.initialize()
        kept.append(camera)
        get_timeline().play()
        _update(8)
        assert camera.get_current_frame()["rgb"].shape == (16, 16, 4)
        assert "rgb" not in kept[0].get_current_frame() or kept[0] is camera
    kept[0].destroy()
    _update(4)
    assert camera.get_rgba().shape == (16, 16, 4)


def test_a_camera_begins_again_on_the_next_stage():
    camera = Camera("/World/Camera", position=(5, 0, 0), resolution=(16, 16))
    camera.initialize()
    _next_stage()
    with pytest.warns(match="rgb is not attached"):
        assert camera.get_rgba() is None
    rep.create.camera(parent="/World")
    Camera("/World/Camera", position=(5, 0, 0), resolution=(16, 16))
    camera.initialize()
    _update(1)
    assert camera.get_rgba().shape == (16, 16, 4)


def test_cameras_in_tiles_that_end_late_leave_the_next_ones():
    views = []
    for _ in range(2):
        _next_stage()
        Camera("/World/Camera", position=(5, 0, 0))
        views.append(CameraView("/World/Camera", camera_resolution=(16, 16), output_annotators=["rgb"]))
    del views[0]
    gc.collect()
    _update(1)
    assert views[0].get_rgb_tiled().shape == (16, 16, 3)


def test_render_variables_are_those_of_the_stage():
    path = _product((8, 8)).path
    SyntheticData.Get().enable_rendervar(path, "LdrColorSD")
    assert SyntheticData.Get().is_rendervar_enabled(path, "LdrColorSD")
    _next_stage()
    assert _product((8, 8)).path == path
    assert not SyntheticData.Get().is_rendervar_enabled(path, "LdrColorSD")


def test_a_new_session_has_a_world_of_its_own():
    world = World(physics_dt=1 / 100)
    session.restart()
    assert World.instance() is None
    stage_context.new_stage()
    assert World(physics_dt=1 / 50) is not world
    assert World.instance().get_physics_dt() == pytest.approx(1 / 50)
    World.clear_instance()


def test_a_world_that_could_not_be_set_up_is_not_returned():
    with pytest.raises(Exception, match="plaid"):
        World(device="plaid")
    assert World(physics_dt=1 / 100).get_physics_dt() == pytest.approx(1 / 100)
    World.clear_instance()
