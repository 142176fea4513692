"""Grasps: antipodal poses against geometry, configuration files, and a gripper that closes on an object."""

import numpy as np
import pytest
import yaml
from pxr import Gf, UsdGeom, UsdPhysics

from tests.articulations.robots import joint, link
from usdsdg.app.app import get_app
from usdsdg.articulations.articulations import get_articulations
from usdsdg.compat.isaacsim.replicator.grasping import grasping_utils, sampler_utils, transform_utils
from usdsdg.compat.isaacsim.replicator.grasping.grasping_manager import GraspingManager
from usdsdg.errors import ArgumentError
from usdsdg.stage.schemas import physx

GRIPPER, OBJECT = "/World/Gripper", "/World/Box"


def _box(stage, size=(0.04, 0.1, 0.2), path=OBJECT):
    """A box as one mesh of quads."""
    stage.DefinePrim(path, "Xform")
    mesh = UsdGeom.Mesh.Define(stage, f"{path}/mesh")
    half = np.array(size) / 2
    corners = [half * ((-1) ** i, (-1) ** j, (-1) ** k) for i in range(2) for j in range(2) for k in range(2)]
    mesh.CreatePointsAttr([Gf.Vec3f(*corner.tolist()) for corner in corners])
    mesh.CreateFaceVertexCountsAttr([4] * 6)
    mesh.CreateFaceVertexIndicesAttr([2, 3, 1, 0, 5, 7, 6, 4, 1, 5, 4, 0, 6, 7, 3, 2, 4, 6, 2, 0, 3, 7, 5, 1])
    return mesh


def _columns(pose) -> np.ndarray:
    location, quat = pose
    return np.array(Gf.Matrix4d().SetTransform(Gf.Rotation(quat), location)).T


def test_grasps_span_the_faces_that_the_gripper_can_hold(stage):
    mesh = _box(stage)
    config = {
        "mesh_prim": mesh, "num_candidates": 200, "gripper_maximum_aperture": 0.08,
        "gripper_standoff_fingertips": 0.17, "random_seed": 3,
    }  # fmt: skip
    poses = list(zip(*sampler_utils.generate_grasp_poses(config)))
    # Only the two faces across x are closer than the aperture: their part of the surface.
    areas = np.array([0.1 * 0.2, 0.04 * 0.2, 0.04 * 0.1])
    assert len(poses) == pytest.approx(200 * areas[0] / areas.sum(), abs=4 * np.sqrt(200 * 0.25))
    for pose in poses:
        matrix = _columns(pose)
        assert abs(matrix[:3, 1]) == pytest.approx([1, 0, 0], abs=1e-6)  # the closing axis
        middle = matrix[:3, 3] + 0.17 * matrix[:3, 2]  # the origin is the standoff behind the middle
        assert middle[0] == pytest.approx(0, abs=1e-6)
        assert abs(middle[1]) <= 0.05 + 1e-6
        assert abs(middle[2]) <= 0.1 + 1e-6


def test_seeds_repeat_and_leave_numpy_alone(stage):
    config = {"mesh_prim": _box(stage), "num_candidates": 20, "random_seed": 5}
    np.random.seed(0)
    expected = np.random.rand()
    np.random.seed(0)
    first, second = sampler_utils.generate_grasp_poses(config), sampler_utils.generate_grasp_poses(config)
    assert first == second
    assert np.random.rand() == expected
    assert sampler_utils.generate_grasp_poses({**config, "random_seed": 6}) != first


def test_orientations_turn_about_the_grasp_axis(stage):
    config = {"mesh_prim": _box(stage), "num_candidates": 40, "num_orientations": 4, "random_seed": 1}
    poses = [_columns(pose) for pose in zip(*sampler_utils.generate_grasp_poses(config))]
    assert len(poses) % 4 == 0
    approaches = [matrix[:3, 2] for matrix in poses[:4]]
    assert np.dot(approaches[0], approaches[2]) == pytest.approx(-1)
    assert np.dot(approaches[0], approaches[1]) == pytest.approx(0, abs=1e-9)


def test_the_middle_varies_along_the_axis_within_the_object(stage):
    config = {"mesh_prim": _box(stage), "num_candidates": 100, "lateral_sigma": 0.01, "random_seed": 1}
    poses = [_columns(pose) for pose in zip(*sampler_utils.generate_grasp_poses(config))]
    middles = np.array([matrix[:3, 3] + 0.1 * matrix[:3, 2] for matrix in poses])[:, 0]
    assert np.abs(middles).max() <= 0.02 + 1e-9
    assert 0.004 < middles.std() < 0.012


def test_scale_in_the_world_counts(stage):
    mesh = _box(stage)
    UsdGeom.Xformable(mesh).AddScaleOp().Set((3, 1, 1))
    config = {"mesh_prim": mesh, "num_candidates": 50, "random_seed": 1}
    assert sampler_utils.generate_grasp_poses(config) == ([], [])  # 0.12 wide and 0.1 deep
    assert len(sampler_utils.generate_grasp_poses({**config, "apply_scale": False})[0]) > 10


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"num_candidates": 0}, "num_candidates is 0"),
        ({"gripper_maximum_aperture": -1.0}, "aperture is -1"),
        ({"grasp_align_axis": (0, 2, 0)}, "grasp_align_axis is"),
    ],
)
def test_wrong_configurations_are_errors(stage, wrong, message):
    with pytest.raises(ArgumentError, match=message):
        sampler_utils.generate_grasp_poses({"mesh_prim": _box(stage), **wrong})


def test_poses_in_the_world_follow_the_object(stage):
    box = _box(stage).GetPrim().GetParent()
    UsdGeom.Xformable(box).AddTranslateOp().Set((1, 2, 3))
    UsdGeom.Xformable(box).AddRotateZOp().Set(90)
    UsdGeom.Xformable(box).AddScaleOp().Set((2, 2, 2))
    location, quat = transform_utils.transform_local_pose_to_world((Gf.Vec3d(1, 0, 0), Gf.Quatd(1)), box)
    assert Gf.IsClose(location, Gf.Vec3d(1, 3, 3), 1e-9)  # without the object's scale
    assert Gf.Rotation(quat).TransformDir(Gf.Vec3d(1, 0, 0))[1] == pytest.approx(1)


def _gripper(stage, path=GRIPPER):
    """Two fingers that slide along y, from 0.05 to the middle; one drives, the other mirrors it."""
    root = stage.DefinePrim(path, "Xform")
    UsdPhysics.ArticulationRootAPI.Apply(root)
    link(stage, f"{path}/palm", (0, 0, 0), 0.02)
    joint(stage, f"{path}/joints/root", UsdPhysics.FixedJoint, "", f"{path}/palm")
    for name, side in (("left", 1), ("right", -1)):
        link(stage, f"{path}/{name}", (0, side * 0.05, 0.1), 0.02)
        made = joint(
            stage, f"{path}/joints/{name}", UsdPhysics.PrismaticJoint, f"{path}/palm", f"{path}/{name}",
            pos0=(0, side * 0.05, 0.1), axis="Y", lower=-0.05, upper=0.05,
        )  # fmt: skip
        physx.JointStateAPI.Apply(made.GetPrim(), "linear")
    drive = UsdPhysics.DriveAPI.Apply(stage.GetPrimAtPath(f"{path}/joints/left"), "linear")
    drive.CreateStiffnessAttr(400.0)
    drive.CreateDampingAttr(40.0)
    mimic = physx.PhysxMimicJointAPI.Apply(stage.GetPrimAtPath(f"{path}/joints/right"), "transY")
    mimic.CreateGearingAttr(1.0)  # position + gearing * leader = 0
    mimic.CreateReferenceJointRel().SetTargets([f"{path}/joints/left"])
    return root


def _manager(stage, folder) -> GraspingManager:
    _gripper(stage)
    box = _box(stage, (0.03, 0.04, 0.03))
    UsdPhysics.CollisionAPI.Apply(box.GetPrim())
    UsdGeom.Xformable(box.GetPrim().GetParent()).AddTranslateOp().Set((0, 0, 0.1))
    manager = GraspingManager()
    assert manager.set_gripper(GRIPPER)
    manager.set_object_prim_path(OBJECT)
    manager.create_and_add_grasp_phase("Close", {f"{GRIPPER}/joints/left": -0.05})
    manager.set_results_output_dir(str(folder))
    return manager


def _evaluate(manager, poses, **options) -> None:
    get_app().run_until_complete(manager.evaluate_grasp_poses(poses, **options))


@pytest.mark.parametrize("use_timeline", [False, True])
def test_fingers_close_until_they_touch_and_open_again_for_the_next_pose(stage, tmp_path, use_timeline):
    manager = _manager(stage, tmp_path)
    poses = [(Gf.Vec3d(0, 0, 0), Gf.Quatd(1)), (Gf.Vec3d(0.5, 0, 0), Gf.Quatd(1))]
    _evaluate(manager, poses, render=False, simulate_using_timeline=use_timeline)
    results = [yaml.safe_load((tmp_path / f"capture_{i}.yaml").read_text())["grasp_result"] for i in range(2)]
    left = [result["joint_states"]["joints/left"] for result in results]
    # At the first pose, fingers of half width 0.01 at 0.05 meet the box of half width 0.02, and press on it.
    assert -0.0202 <= left[0] < -0.0195
    assert left[1] == pytest.approx(-0.04, abs=2e-4)  # beside the box the fingers meet each other
    assert results[0]["joint_states"]["joints/right"] == pytest.approx(-left[0], abs=1e-4)
    assert results[1]["gripper_location"] == [0.5, 0, 0]
    assert results[1]["object_path"] == OBJECT
    assert get_articulations().at(GRIPPER).positions == pytest.approx(
        [0, 0], abs=1e-6
    )  # and the gripper is where it was
    assert transform_utils.get_prim_world_pose(manager.gripper_prim)[0] == Gf.Vec3d(0)


def test_results_take_free_numbers_unless_they_may_overwrite(stage, tmp_path):
    manager = _manager(stage, tmp_path)
    (tmp_path / "capture_0.yaml").write_text("mine")
    manager.write_grasp_results(Gf.Vec3d(0), Gf.Quatd(1))
    assert (tmp_path / "capture_0.yaml").read_text() == "mine"
    assert (tmp_path / "capture_1.yaml").exists()


def test_a_configuration_is_read_as_it_was_written(stage, tmp_path):
    manager = _manager(stage, tmp_path)
    manager.sampler_config["num_candidates"] = 7
    manager.update_joint_pregrasp_states_from_current()
    assert manager.generate_grasp_poses({"random_seed": 2, "num_candidates": 5})
    manager.save_config(str(tmp_path / "grasp.yaml"))
    other = GraspingManager()
    status = other.load_config(str(tmp_path / "grasp.yaml"))
    assert set(status.values()) == {"Success"}
    assert other.gripper_path == GRIPPER
    assert other.get_grasp_phases_as_dicts() == manager.get_grasp_phases_as_dicts()
    assert other.sampler_config == manager.sampler_config
    assert other.joint_pregrasp_states.keys() == {f"{GRIPPER}/joints/{name}" for name in ("root", "left", "right")}
    assert np.allclose(other.grasp_locations, manager.grasp_locations)


def test_what_a_configuration_names_must_exist(stage, tmp_path):
    file = tmp_path / "grasp.yaml"
    file.write_text(
        yaml.safe_dump({
            "gripper_path": "/World/None",
            "grasp_phases": [{"name": "Close", "joint_drive_targets": {"/World/None/joint": 1.0}}],
            "object_path": "/World/None",
            "sampler_config": {"num_candidates": "many", "other": 1},
        })
    )  # fmt: skip
    status = GraspingManager().load_config(str(file))
    assert status["gripper"] == "Failed (there is no prim '/World/None')"
    assert status["phases"].startswith("Failed")
    assert status["object"].startswith("Failed")
    assert status["poses"] == "Not in file"
    assert GraspingManager().load_config(str(tmp_path / "none.yaml"))["gripper"].startswith("Failed")


def test_joints_are_listed_and_their_states_move_links(stage):
    _gripper(stage)
    info = {each["path"].rsplit("/", 1)[1]: each for each in grasping_utils.get_gripper_joints_info(GRIPPER)}
    assert info["left"]["is_valid_grasp_joint"]
    assert not info["right"]["is_drive"]
    assert info["right"]["is_mimic"]
    grasping_utils.apply_joint_pregrasp_states({f"{GRIPPER}/joints/left": -0.02})
    left, right = (stage.GetPrimAtPath(f"{GRIPPER}/{name}") for name in ("left", "right"))
    assert transform_utils.get_prim_world_pose(left)[0][1] == pytest.approx(0.03)
    assert transform_utils.get_prim_world_pose(right)[0][1] == pytest.approx(-0.03)
    states = grasping_utils.get_gripper_joint_states(GRIPPER)
    assert states == pytest.approx({"joints/root": 0.0, "joints/left": -0.02, "joints/right": 0.02})
