"""Cameras that are aimed again: what they see, from where, and that nothing changes where the key is absent."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdLux, UsdPhysics

from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.object_based import aiming
from usdsdg.scenarios.object_based.aiming import Aiming
from usdsdg.scenarios.object_based.cameras import Cameras
from usdsdg.scenarios.object_based.config import ObjectBasedConfig
from usdsdg.session import engines
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg.stage.poses.xform_ops import author_pose

SIZE = 0.15
SETTINGS = {
    "labeled_assets_and_properties": [{"url": "/Isaac/a.usd", "label": "a"}],
    "camera_distance_to_target_min_max": [0.4, 0.8],
    "camera_look_at_target_offset": 0.05,
    "resolution": [160, 120],
}


class NothingInTheWay:
    def overlap_sphere(self, radius, origin):
        return []


@pytest.fixture
def camera(stage, monkeypatch) -> Usd.Prim:
    monkeypatch.setattr(engines, "physics", NothingInTheWay)
    prim = UsdGeom.Camera.Define(stage, "/World/Camera").GetPrim()
    UsdGeom.Camera(prim).GetClippingRangeAttr().Set((0.01, 100.0))
    author_pose(prim, translate=(0, 0, 0), orient=Gf.Quatf(1))
    return prim


def target(stage: Usd.Stage, name: str, position) -> Usd.Prim:
    cube = UsdGeom.Cube.Define(stage, f"/World/{name}")
    cube.CreateSizeAttr(SIZE)
    author_pose(cube.GetPrim(), translate=position)
    return cube.GetPrim()


def aim(camera: Usd.Prim, targets: list[Usd.Prim], frame: int, exposure: float = 0.0) -> None:
    made = Aiming(Cameras([camera], []), targets, ObjectBasedConfig.model_validate(SETTINGS), Draws(0))
    author_pose(camera, translate=(0, 0, 0))
    made.remember_places()
    made.aim(camera.GetStage(), frame, exposure=exposure)


def shown(camera: Usd.Prim, prim: Usd.Prim) -> float:
    """The fraction of the camera's image that shows a prim."""
    renderer = engines.renderer()
    renderer.sync()
    (found,) = renderer.labels_of([read_camera(camera.GetStage(), camera.GetPath(), (160, 120))], ("instance",))
    return float((found["instance"] == renderer.gprims.index(str(prim.GetPath()))).mean())


@pytest.mark.parametrize("frame", range(4))
def test_a_camera_shows_its_target_from_a_distance_within_the_range(stage, camera, frame):
    cube = target(stage, "Cube", (2.0, 0.5, 0.0))
    aim(camera, [cube], frame)
    eye = np.array(camera.GetAttribute("xformOp:translate").Get())
    # The point that is looked at is at most this far from the target.
    offset = np.sqrt(3) * 0.05
    assert 0.4 - offset <= np.linalg.norm(eye - (2.0, 0.5, 0.0)) <= 0.8 + offset
    # It came from its own place, which is the origin.
    assert np.linalg.norm(eye) < 2.0
    assert shown(camera, cube) > aiming.LEAST * (1 - 2 * aiming.BORDER) ** 2


def test_frames_are_seen_from_elsewhere(stage, camera):
    cube = target(stage, "Cube", (2.0, 0.5, 0.0))
    eyes = []
    for frame in range(3):
        aim(camera, [cube], frame)
        eyes.append(tuple(camera.GetAttribute("xformOp:translate").Get()))
    assert len(set(eyes)) == 3
    aim(camera, [cube], 0)
    assert tuple(camera.GetAttribute("xformOp:translate").Get()) == eyes[0]


def test_what_is_hidden_is_not_chosen(stage, camera):
    behind, free = target(stage, "Behind", (2.0, 0.0, 0.0)), target(stage, "Free", (0.0, 2.0, 0.0))
    wall = UsdGeom.Cube.Define(stage, "/World/Wall")
    wall.CreateSizeAttr(1.0)
    # Nearer to the target than any camera.
    author_pose(wall.GetPrim(), translate=(1.8, 0, 0), scale=(0.05, 3, 3))
    for frame in range(6):
        aim(camera, [behind, free], frame)
        assert shown(camera, free) > 0.0


def test_what_is_behind_a_light_is_not_chosen(stage, camera):
    behind, free = target(stage, "Behind", (2.0, 0.0, 0.0)), target(stage, "Free", (0.0, 2.0, 0.0))
    light = UsdLux.SphereLight.Define(stage, "/World/Light")
    light.CreateRadiusAttr(0.15)
    author_pose(light.GetPrim(), translate=(1.8, 0, 0), scale=(2, 2, 2))
    for frame in range(6):
        aim(camera, [behind, free], frame)
        assert shown(camera, free) > 0.0


def test_streaks_are_not_chosen_where_images_are_exposed(stage, camera):
    fast, slow = target(stage, "Fast", (2.0, 0.0, 0.0)), target(stage, "Slow", (0.0, 2.0, 0.0))
    UsdPhysics.RigidBodyAPI.Apply(fast).CreateVelocityAttr((0.0, 4.0, 0.0))
    chosen = []
    for exposure in (0.0, 0.025):
        for frame in range(6):
            aim(camera, [fast, slow], frame, exposure)
            chosen.append(shown(camera, fast) > shown(camera, slow))
    assert any(chosen[:6])
    assert not any(chosen[6:])


def test_where_nothing_can_be_seen_a_camera_stays(stage, camera, monkeypatch):
    class Crowded:
        def overlap_sphere(self, radius, origin):
            return ["something"]

    monkeypatch.setattr(engines, "physics", Crowded)
    aim(camera, [target(stage, "Cube", (2.0, 0.5, 0.0))], 0)
    assert tuple(camera.GetAttribute("xformOp:translate").Get()) == (0, 0, 0)


def test_the_key_is_off_where_it_is_absent():
    assert not ObjectBasedConfig.model_validate(SETTINGS).camera_aim_again
