"""`omni.isaac.python_app`, `omni.isaac.synthetic_utils` and the legacy viewport, as of Isaac Sim 2021."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

import usdsdg as rep
from usdsdg.compat.omni.isaac.python_app import OmniKitHelper
from usdsdg.compat.omni.isaac.synthetic_utils import SyntheticDataHelper
from usdsdg.compat.omni.kit import viewport, viewport_legacy
from usdsdg.errors import ArgumentError
from usdsdg.session.settings.store import get_settings


@pytest.fixture
def kit(stage):
    helper = OmniKitHelper({"width": 32, "height": 24, "renderer": "RayTracedLighting", "experience": "x.kit"})
    rep.orchestrator.set_capture_on_play(False)
    yield helper
    helper.shutdown()
    assert helper.is_exiting()


def test_the_application_is_updated_by_seconds_with_physics_steps_of_their_own(kit):
    assert get_settings().get("/rtx/rendermode") == "RaytracedLighting"
    kit.set_up_axis(UsdGeom.Tokens.y)
    assert UsdGeom.GetStageUpAxis(kit.get_stage()) == "Y"
    scene = kit.get_stage().DefinePrim("/physicsScene", "PhysicsScene")
    kit.play()
    start = kit.timeline.get_current_time()
    kit.update(1 / 30, 1 / 120, 4)
    kit.update(0.1)
    assert kit.timeline.get_current_time() - start == pytest.approx(1 / 30 + 0.1)
    assert scene.GetAttribute("physxScene:timeStepsPerSecond").Get() == 10
    kit.update()
    assert kit.timeline.get_current_time() - start == pytest.approx(1 / 30 + 0.1 + 1 / 60)
    assert (kit.is_loading(), kit.is_exiting()) == (False, False)
    kit.stop()
    assert kit.timeline.is_stopped()


def test_prims_are_created_with_angles_about_x_then_y_then_z(kit):
    made = kit.create_prim("/World/a", "Cube", translation=(1, 2, 3), rotation=(10, 20, 30), scale=(1, 2, 3))
    other = kit.get_stage().DefinePrim("/World/b", "Cube")
    api = UsdGeom.XformCommonAPI(other)
    api.SetTranslate((1, 2, 3))
    api.SetRotate((10, 20, 30), UsdGeom.XformCommonAPI.RotationOrderXYZ)
    api.SetScale((1, 2, 3))
    cache = UsdGeom.XformCache(Usd.TimeCode.Default())
    assert Gf.IsClose(cache.GetLocalToWorldTransform(made), cache.GetLocalToWorldTransform(other), 1e-5)


def test_sensors_of_the_viewport_are_read_by_their_names(kit):
    kit.create_prim("/World/box", "Cube", translation=(0, 0, -20), semantic_label="box")
    kit.create_prim("/World/ball", "Sphere", translation=(3, 0, -20), semantic_label="ball")
    camera = kit.create_prim("/World/camera", "Camera", translation=(0, 0, 0))
    kit.create_prim("/World/light", "DomeLight", attributes={"inputs:intensity": 500.0})
    window = viewport.get_viewport_interface().get_viewport_window()
    window.set_active_camera(str(camera.GetPath()))
    window.set_texture_resolution(32, 24)
    assert (window.get_active_camera(), window.get_texture_resolution()) == ("/World/camera", (32, 24))
    helper = SyntheticDataHelper()
    names = ["rgb", "depth", "depthLinear", "instanceSegmentation", "semanticSegmentation", "boundingBox2DTight"]
    found = helper.get_groundtruth([*names, "boundingBox3D", "camera", "pose"], window)
    assert found["rgb"].shape == (24, 32, 4)
    assert found["depth"][12, 16] == pytest.approx(19.0)
    assert found["depthLinear"][12, 16] == pytest.approx(19.0, abs=0.01)
    image, table = found["instanceSegmentation"]
    by_name = {row["name"]: row for row in table}
    assert image[12, 16] == by_name["/World/box"]["uniqueId"]
    assert {row["semanticLabel"] for row in found["boundingBox2DTight"]} == {"box", "ball"}
    assert np.ptp(found["boundingBox3D"][0]["corners"], axis=0) == pytest.approx([2, 2, 2])
    assert found["camera"]["pose"][3, :3].tolist() == [0, 0, 0]
    assert found["camera"]["resolution"] == {"width": 32, "height": 24}
    poses = {path: (label, pose[3, :3].tolist()) for path, _, label, pose in found["pose"]}
    assert poses["/World/ball"] == ("ball", [3, 0, -20])
    assert found["state"] == dict.fromkeys([*names, "boundingBox3D", "camera", "pose"], True)
    ids = helper.get_semantic_id_map(["box", "ball", "none"])
    assert ids["none"] == 0
    assert helper.get_semantic_label_map([ids["ball"], 99]) == {ids["ball"]: "ball", 99: ""}
    mapped = np.array(helper.get_mapped_semantic_data(found["semanticSegmentation"], {"box": 40}))
    assert set(np.unique(mapped[found["semanticSegmentation"] == ids["box"]])) == {40}
    assert set(helper.get_semantic_ids(mapped)) == {0, ids["ball"], 40}
    with pytest.raises(ArgumentError, match="no sensor 'rbg'; known: rgb"):
        helper.get_groundtruth(["rbg"], window)


def test_the_legacy_viewport_places_cameras(kit):
    window = viewport_legacy.get_default_viewport_window()
    window.set_camera_position("/OmniverseKit_Persp", 4.0, 0.0, 0.0, True)
    window.set_camera_target("/OmniverseKit_Persp", 0.0, 0.0, 0.0, True)
    assert window.get_camera_position("/OmniverseKit_Persp") == pytest.approx((True, 4, 0, 0))
    assert window.get_camera_target("/OmniverseKit_Persp") == pytest.approx((True, 0, 0, 0), abs=1e-6)
    to_world = UsdGeom.XformCache().GetLocalToWorldTransform(kit.get_stage().GetPrimAtPath("/OmniverseKit_Persp"))
    assert to_world.TransformDir(Gf.Vec3d(0, 0, -1)) == pytest.approx((-1, 0, 0), abs=1e-6)
