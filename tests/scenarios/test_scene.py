"""The scene of the object-based scenario on a stage, without engines."""

from __future__ import annotations

import re

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdPhysics

import usdsdg as rep
from usdsdg.app.app import get_app
from usdsdg.errors import AssetNotFound, UsdsdgWarning, WriterError, forget_warnings
from usdsdg.scenarios import environment
from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.object_based import cameras, objects, randomizers
from usdsdg.scenarios.object_based import job as object_based
from usdsdg.scenarios.object_based.config import ObjectBasedConfig
from usdsdg.scenarios.output_folder import with_absolute_output_dir
from usdsdg.session import engines, stage_context
from usdsdg.stage import assets
from usdsdg.stage.poses.transforms import local_to_world
from usdsdg.stage.schemas import physx
from usdsdg.stage.semantics import labels


@pytest.fixture(autouse=True)
def assets_root(tmp_path):
    """Two assets, one of them with a label of its own."""
    folder = tmp_path / "Isaac"
    folder.mkdir()
    for name in ("mug", "crate"):
        stage = Usd.Stage.CreateNew(str(folder / f"{name}.usda"))
        root = UsdGeom.Xform.Define(stage, f"/{name}")
        stage.SetDefaultPrim(root.GetPrim())
        UsdGeom.Cube.Define(stage, f"/{name}/shape")
        labels.add_labels(stage.GetPrimAtPath(f"/{name}/shape"), {"class": ["inside"]})
        stage.GetRootLayer().Save()
    room = Usd.Stage.CreateNew(str(folder / "room.usda"))
    floor = UsdGeom.Cube.Define(room, "/Room/Floor").GetPrim()
    labels.add_labels(floor, {"class": ["floor"]})
    UsdPhysics.Scene.Define(room, "/Room/Physics")
    room.GetRootLayer().Save()
    for url in randomizers.DOME_TEXTURES:
        sky = tmp_path / url.lstrip("/")
        sky.parent.mkdir(parents=True, exist_ok=True)
        sky.write_bytes(b"")
    assets.set_assets_root(tmp_path)
    yield
    assets.set_assets_root(None)


MUGS = {"url": "/Isaac/mug.usda", "label": "mug", "floating": True, "scale_min_max": (0.1, 0.2)}


def config(**changes) -> ObjectBasedConfig:
    values = {
        "working_area_size": (4, 5, 3),
        "labeled_assets_and_properties": [
            {**MUGS, "count": 3},
            {"url": "/Isaac/crate.usda", "label": "big crate", "count": 2},
        ],
        "shape_distractors_num": 12,
        "mesh_distractors_urls": ["/Isaac/mug.usda", "/Isaac/crate.usda"],
        "mesh_distractors_num": 6,
        "num_cameras": 2,
        "camera_collider_radius": 0.5,
        "camera_properties_kwargs": {"focalLength": 30.0, "clippingRange": [0.1, 50.0]},
        **changes,
    }
    return ObjectBasedConfig.model_validate(values)


def scene(**changes):
    chosen = config(**changes)
    return object_based.build_scene(chosen, Draws(chosen.seed))


def poses(prims) -> dict[str, np.ndarray]:
    return {str(prim.GetPath()): np.array(local_to_world(prim)) for prim in prims}


def test_objects_have_the_labels_and_counts_of_the_configuration_and_are_rigid_bodies():
    made = scene()
    assert [labels.get_labels(prim) for prim in made.labeled.floating] == [{"class": ["mug"]}] * 3
    assert [str(prim.GetPath()) for prim in made.labeled.falling] == [
        "/World/Labeled/big_crate",
        "/World/Labeled/big_crate_01",
    ]
    for prim in [*made.labeled.all, *made.shapes.all, *made.meshes.all]:
        assert prim.HasAPI(UsdPhysics.RigidBodyAPI)
        assert any(below.HasAPI(UsdPhysics.CollisionAPI) for below in Usd.PrimRange(prim))
    assert len(made.shapes.all) == 12
    assert len(made.meshes.all) == 6


def test_gravity_is_disabled_only_for_floating_bodies():
    made = scene()
    for bodies in (made.labeled, made.shapes, made.meshes):
        for prim in bodies.all:
            assert physx.PhysxRigidBodyAPI(prim).GetDisableGravityAttr().Get() is (prim in bodies.floating)
    assert made.shapes.floating
    assert made.shapes.falling


def test_distractors_carry_no_labels():
    made = scene()
    for prim in [*made.shapes.all, *made.meshes.all]:
        for below in Usd.PrimRange(prim):
            assert labels.get_labels(below) == {}


def test_objects_start_inside_the_working_area_with_scales_of_their_range():
    made = scene()
    assert min(map(len, (made.labeled.floating, made.shapes.all, made.meshes.all))) > 0
    for prim in [*made.labeled.all, *made.shapes.all, *made.meshes.all]:
        assert (np.abs(np.array(local_to_world(prim).ExtractTranslation())) <= (2.0, 2.5, 1.5)).all()
    for prim in made.labeled.floating:
        lengths = np.linalg.norm(np.array(local_to_world(prim))[:3, :3], axis=1)
        assert lengths == pytest.approx(lengths[0])
        assert 0.1 <= lengths[0] <= 0.2


@pytest.mark.parametrize(
    "change",
    [
        {"shape_distractors_num": 20},
        {"mesh_distractors_num": 3},
        {"num_cameras": 1},
        {"labeled_assets_and_properties": [{**MUGS, "count": 4}]},
    ],
)
def test_changing_one_number_leaves_all_other_poses(change):
    def everything(made) -> dict[str, np.ndarray]:
        return poses([*made.labeled.all, *made.shapes.all, *made.meshes.all])

    before = everything(scene())
    after = everything(scene(**change))
    shared = before.keys() & after.keys()
    assert len(shared) >= 12
    assert all(np.array_equal(before[path], after[path]) for path in shared)


def test_one_seed_repeats_its_poses_and_another_gives_different_ones():
    first, again, other = (poses(scene(seed=seed).labeled.all) for seed in (1, 1, 2))
    assert all(np.array_equal(first[path], again[path]) for path in first)
    assert not any(np.array_equal(first[path], other[path]) for path in first)


def test_invisible_walls_enclose_the_working_area():
    stage = scene().stage
    size = np.array([4.0, 5.0, 3.0])
    cache = UsdGeom.BBoxCache(
        Usd.TimeCode.Default(), [UsdGeom.Tokens.default_], useExtentsHint=False, ignoreVisibility=True
    )
    walls = stage.GetPrimAtPath("/World/CollisionWalls").GetChildren()
    assert {wall.GetName() for wall in walls} == {
        "floor", "ceiling", "left_wall", "right_wall", "front_wall", "back_wall",
    }  # fmt: skip
    inner_faces = set()
    for wall in walls:
        box = cache.ComputeWorldBound(wall).ComputeAlignedRange()
        low, high = np.array(box.GetMin()), np.array(box.GetMax())
        thin = int(np.argmin(high - low))
        assert (high - low)[thin] == pytest.approx(environment.WALL_THICKNESS)
        assert np.delete(high - low, thin) == pytest.approx(np.delete(size, thin))
        inner_faces.add((thin, float(np.round(low[thin] if low[thin] > 0 else high[thin], 6))))
        assert UsdGeom.Imageable(wall).ComputeVisibility() == "invisible"
        assert wall.HasAPI(UsdPhysics.CollisionAPI)
        assert not wall.HasAPI(UsdPhysics.RigidBodyAPI)
    assert inner_faces == {(axis, side * size[axis] / 2) for axis in range(3) for side in (-1, 1)}


class OccupiedSpace:
    """Physics that reports every position as occupied until it has been asked `occupied` times."""

    def __init__(self, occupied: int) -> None:
        self.occupied, self.asked = occupied, []

    def overlap_sphere(self, radius, origin):
        self.asked.append(tuple(origin))
        return ["something"] if len(self.asked) <= self.occupied else []


@pytest.mark.parametrize(("near", "warned"), [(0.3, True), (0.2, False)])
def test_cameras_that_come_nearer_than_their_clipping_plane_are_warned_of(near, warned, recwarn):
    forget_warnings()
    properties = {"clippingRange": (near, 100)}
    object_based.build_scene(
        config(camera_distance_to_target_min_max=(0.25, 0.75), camera_properties_kwargs=properties), Draws(0)
    )
    warnings = [str(warning.message) for warning in recwarn if "clipping plane" in str(warning.message)]
    assert (
        warnings
        == [
            "cameras come as near as 0.25 to what they look at and see nothing nearer than 0.3, their clipping plane: "
            "add clippingRange: [0.01, 1000] to camera_properties_kwargs"
        ]
        * warned
    )


def test_cameras_try_positions_until_one_is_free(monkeypatch):
    space = OccupiedSpace(occupied=3)
    monkeypatch.setattr(engines, "physics", lambda: space)
    chosen = config(num_cameras=1)
    made = object_based.build_scene(chosen, Draws(0))
    cameras.look_at_targets(made.cameras, made.labeled.all, chosen, Draws(0), 0)
    assert len(set(space.asked)) == 4
    assert tuple(local_to_world(made.cameras.prims[0]).ExtractTranslation()) == pytest.approx(space.asked[-1])


def test_cameras_take_the_last_position_where_all_are_occupied(monkeypatch):
    space = OccupiedSpace(occupied=10_000)
    monkeypatch.setattr(engines, "physics", lambda: space)
    chosen = config(num_cameras=1)
    made = object_based.build_scene(chosen, Draws(0))
    cameras.look_at_targets(made.cameras, made.labeled.all, chosen, Draws(0), 0)
    assert len(space.asked) == cameras.MAX_ATTEMPTS


def test_cameras_look_at_a_target_from_a_distance_of_the_range(monkeypatch):
    monkeypatch.setattr(engines, "physics", lambda: OccupiedSpace(occupied=0))
    chosen = config(camera_look_at_target_offset=0.0, camera_distance_to_target_min_max=(0.25, 0.75))
    made = object_based.build_scene(chosen, Draws(0))
    targets = [np.array(local_to_world(prim).ExtractTranslation()) for prim in made.labeled.all]
    for index in range(20):
        cameras.look_at_targets(made.cameras, made.labeled.all, chosen, Draws(0), index)
        for camera in made.cameras.prims:
            matrix = np.array(local_to_world(camera))
            to_targets = np.array(targets) - matrix[3, :3]
            distance = np.linalg.norm(to_targets, axis=1)
            # Cameras look along -Z: on some target, 0.25 to 0.75 m ahead, the view axis passes.
            aimed = np.abs(to_targets / distance[:, None] + matrix[2, :3]).max(axis=1) < 1e-5
            assert ((distance[aimed] > 0.2499) & (distance[aimed] < 0.7501)).any()


def test_cameras_have_the_configured_properties_and_disabled_collision_spheres():
    made = scene()
    camera = UsdGeom.Camera(made.cameras.prims[0])
    assert camera.GetFocalLengthAttr().Get() == 30.0
    assert camera.GetClippingRangeAttr().Get() == Gf.Vec2f(0.1, 50.0)
    sphere = made.cameras.spheres[1]
    enabled = UsdPhysics.CollisionAPI(sphere).GetCollisionEnabledAttr()
    assert str(sphere.GetPath()) == "/World/Cameras/cam_1/CollisionSphere"
    assert UsdGeom.Sphere(sphere).GetRadiusAttr().Get() == 0.5
    assert enabled.Get() is False
    made.cameras.set_colliding(True)
    assert enabled.Get() is True


def test_an_environment_loses_its_labels_and_keeps_its_physics_scene():
    made = scene(env_url="/Isaac/room.usda")
    assert labels.get_labels(made.stage.GetPrimAtPath("/Room/Floor")) == {}
    assert str(made.physics_scene.GetPath()) == "/Room/Physics"
    assert physx.PhysxSceneAPI(made.physics_scene).GetTimeStepsPerSecondAttr().Get() == 60
    assert not made.stage.GetPrimAtPath("/PhysicsScene")


def test_all_missing_assets_are_named_before_any_work():
    wrong = config(mesh_distractors_urls=["/Isaac/mugg.usda", "/Isaac/table.usda"], env_url="/Isaac/rooom.usda")
    with pytest.raises(AssetNotFound) as caught:
        object_based.check_assets(wrong)
    assert "3 of 9 assets are missing" in str(caught.value)
    for name in ("mugg.usda", "table.usda", "rooom.usda", "mug.usda", "room.usda"):
        assert name in str(caught.value)


def test_an_assets_root_that_is_no_folder_is_reported_once(tmp_path):
    assets.set_assets_root(tmp_path / "gone")
    with pytest.raises(AssetNotFound) as caught:
        object_based.check_assets(config())
    assert str(caught.value).count("is not a folder") == 1


def test_pulls_reach_the_origin_in_one_to_ten_seconds():
    made = scene()
    randomizers.pull_to_center(made.labeled.all, Draws(0), 0)
    assert len(made.labeled.all) > 0
    for prim in made.labeled.all:
        position = np.array(prim.GetAttribute("xformOp:translate").Get())
        velocity = np.array(prim.GetAttribute("physics:velocity").Get())
        seconds = -np.linalg.norm(position) / (velocity @ position / np.linalg.norm(position))
        assert 1.0 - 1e-4 <= seconds <= 10.0 + 1e-4
        assert np.cross(position, velocity) == pytest.approx(0.0, abs=1e-5)


def test_objects_of_two_entries_with_one_label_have_different_poses():
    twice = [{"url": "/Isaac/mug.usda", "label": "mug"}] * 2
    stage_context.new_stage()
    first, second = objects.add_labeled_assets(
        stage_context.current_stage(), config(labeled_assets_and_properties=twice), Draws(0)
    ).all
    assert not np.allclose(np.array(local_to_world(first)), np.array(local_to_world(second)))


@pytest.mark.parametrize("without", ["shape_distractors_num", "mesh_distractors_num"])
def test_randomizers_work_without_distractors(without, recwarn):
    chosen = config(**{without: 0})
    made = object_based.build_scene(chosen, Draws(0))
    object_based.add_randomizers(chosen, made, Draws(0))()
    for event in (randomizers.COLORS, randomizers.VELOCITIES, randomizers.LIGHTS, randomizers.BACKGROUND):
        rep.utils.send_og_event(event_name=event)
    get_app().update()
    assert not [warning for warning in recwarn if "send_og_event" in str(warning.message)]


def test_each_event_changes_only_its_own_attributes():
    chosen = config()
    made = object_based.build_scene(chosen, Draws(0))
    object_based.add_randomizers(chosen, made, Draws(0))()

    def state() -> dict[str, list]:
        stage = made.stage
        lights = [prim for prim in stage.Traverse() if prim.GetTypeName() == "SphereLight"]
        dome = next(prim for prim in stage.Traverse() if prim.GetTypeName() == "DomeLight")
        return {
            randomizers.LIGHTS: [prim.GetAttribute("inputs:color").Get() for prim in lights],
            randomizers.BACKGROUND: [np.array(local_to_world(dome)).tolist()],
            randomizers.VELOCITIES: [
                prim.GetAttribute("physics:velocity").Get() for prim in [*made.shapes.floating, *made.meshes.floating]
            ],
        }

    for event in (randomizers.LIGHTS, randomizers.BACKGROUND, randomizers.VELOCITIES):
        # The first firing sets what was never set; the second one must change it again.
        for _ in range(2):
            before = state()
            rep.utils.send_og_event(event_name=event)
            get_app().update()
            after = state()
            for name, values in after.items():
                changed = [old != new for old, new in zip(before[name], values)]
                assert all(changed) if name == event else not any(changed)
    assert len(after[randomizers.LIGHTS]) == 3
    assert all(0.0 < component < 1.0 for color in after[randomizers.LIGHTS] for component in color)


@pytest.mark.parametrize(
    ("output_dir", "expected"), [("_out", "here/_out"), ("~/data", "home/data"), ("{home}/abs", "home/abs")]
)
def test_output_folders_are_relative_to_the_working_directory(tmp_path, monkeypatch, output_dir, expected):
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    given = {"output_dir": output_dir.format(home=tmp_path / "home")}
    chosen = config(writer_type="PoseWriter", writer_kwargs=given)
    assert object_based.make_writer(chosen).backend.output_dir == str(tmp_path / expected)
    # The configuration itself stays as it was written.
    assert chosen.writer_kwargs == given
    assert not any(path.name.startswith("~") for path in tmp_path.rglob("*"))


@pytest.mark.parametrize(
    ("bucket", "stays"),
    [
        ({"s3_bucket": "mine"}, True),
        ({"s3_bucket": "mine", "use_s3": True}, True),
        ({"s3_bucket": "mine", "use_s3": False}, False),
        ({}, False),
    ],
)
def test_prefixes_in_a_bucket_are_left_unchanged(tmp_path, monkeypatch, bucket, stays):
    monkeypatch.chdir(tmp_path)
    assert with_absolute_output_dir({"output_dir": "runs/7", **bucket}) == {
        "output_dir": "runs/7" if stays else str(tmp_path / "runs/7"), **bucket
    }  # fmt: skip


@pytest.mark.parametrize(
    ("writer", "arguments", "message"),
    [
        ("BasicWriter", {"output_dir": 3}, "output_dir is 3; expected text or a path"),
        ("PoseWriter", {"output_dir": "x", "format": "dopee"}, "'dopee' does not exist"),
    ],
)
def test_wrong_writers_are_errors_before_the_scene_is_built(monkeypatch, tmp_path, writer, arguments, message):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(object_based, "build_scene", lambda *_: pytest.fail("the scene was built first"))
    with pytest.raises(WriterError, match=re.escape(message)):
        object_based.run(config(writer_type=writer, writer_kwargs=arguments))
    assert not list(tmp_path.glob("x"))


def test_a_configuration_without_a_writer_says_that_nothing_is_written(capsys):
    chosen = config()
    assert object_based.make_writer(chosen) is None
    assert "nothing is written" in capsys.readouterr().err


def test_odd_sizes_of_labeled_assets_are_named():
    forget_warnings()
    small = {**MUGS, "count": 1, "scale_min_max": (1e-4, 1e-4)}
    with pytest.warns(UsdsdgWarning, match=r"mug\.usda is 0\.000\d+ m large on the stage.*scale_min_max"):
        objects.add_labeled_assets(stage_context.new_stage(), config(labeled_assets_and_properties=[small]), Draws(0))
    large = {**MUGS, "count": 1, "scale_min_max": (100.0, 100.0)}
    with pytest.warns(UsdsdgWarning, match=r"mug\.usda is \d+\.?\d* m large on the stage"):
        objects.add_labeled_assets(stage_context.new_stage(), config(labeled_assets_and_properties=[large]), Draws(0))
