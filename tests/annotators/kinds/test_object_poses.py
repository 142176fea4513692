"""The annotators dope and pose: Isaac Sim's numbers of each object, computed one by one in another way."""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.annotators.ray_caster import add_cube, make_frame, new_stage
from tests.annotators.scenes import add_camera
from usdsdg import annotators
from usdsdg.annotators import AnnotatorRegistry

SIZE = (64, 48)
MUG = {"translate": (0.4, -0.2, 0.3), "rotate": (20, 30, 40), "scale": (2, 2, 2)}
STRETCHED = {"translate": (-1.5, 0.8, 0), "rotate": (70, 0, 10), "scale": (0.4, 1.5, 0.8)}
# In DOPE's own cuboid x is to the right, y down and z ahead: front is z max, top is y min.
DOPE_CORNERS = [(x, y, z) for z in "+-" for x, y in ("+-", "--", "-+", "++")]


@pytest.fixture(scope="module")
def frame():
    stage = new_stage()
    add_cube(stage, "/World/Mug", "mug", **MUG)
    add_cube(stage, "/World/Stretched", "box", **STRETCHED)
    add_cube(stage, "/World/Behind", "hidden", translate=(-0.08, 1.54, -2.0), scale=(0.3, 0.3, 0.3))
    add_cube(stage, "/World/Aside", "mug", translate=(40, 0, 0))
    return make_frame(stage, SIZE, camera=add_camera(stage, "/World/Eye", (2, -6, 8), (0, 0, 0)))


def compute(frame, name, **params):
    found = annotators.get(name, {"semanticTypes": ["class"], **params}).compute(frame)
    return found.data, found.info


def in_camera(frame, points):
    """Points of the world in the camera of OpenCV, and their pixels from the corner of the picture."""
    camera = frame.camera
    turned = np.array(points) @ camera.world_to_camera[:3, :3] + camera.world_to_camera[3, :3]
    turned = turned * (1, -1, -1)
    return turned, turned[..., :2] / turned[..., 2:] * camera.fx + (camera.cx, camera.cy)


def turn_of(pose):
    return Rotation.from_euler("xyz", pose["rotate"], degrees=True)


def camera_turn(frame):
    return Rotation.from_euler("x", 180, degrees=True) * Rotation.from_matrix(frame.camera.world_to_camera[:3, :3].T)


def test_dope_lists_what_is_in_view_hidden_or_not(frame):
    rows, info = compute(frame, "dope")
    assert info["primPaths"] == ["/World/Mug", "/World/Stretched", "/World/Behind"]
    assert [info["idToLabels"][str(row["semanticId"])]["class"] for row in rows] == ["mug", "box", "hidden"]
    assert rows["visibility"][2] == 0
    assert rows["visibility"][0] == 1


@pytest.mark.parametrize(("row", "pose"), [(0, MUG), (1, STRETCHED)])
def test_dope_has_location_rotation_and_keypoints_in_the_camera_of_opencv(frame, row, pose):
    (found, _) = compute(frame, "dope")
    location, center = in_camera(frame, [pose["translate"]])
    np.testing.assert_allclose(found["location"][row], location[0] * 100, rtol=1e-5)
    turn = camera_turn(frame) * turn_of(pose)
    assert (Rotation.from_quat(np.roll(found["rotation"][row], -1)).inv() * turn).magnitude() < 1e-5
    corners = [[0.5 if sign == "+" else -0.5 for sign in each] for each in DOPE_CORNERS]
    world = turn_of(pose).apply(np.array(corners) * pose["scale"]) + pose["translate"]
    expected = np.concatenate([in_camera(frame, world)[1], center])
    np.testing.assert_allclose(found["projected_cuboid"][row], expected, atol=1e-3)


def test_without_a_turn_rows_count_from_the_bottom(frame):
    turned, _ = compute(frame, "dope")
    plain, _ = compute(frame, "dope", cameraRotation=(0, 0, 0))
    columns, rows = plain["projected_cuboid"].T
    np.testing.assert_allclose(columns, turned["projected_cuboid"].T[0], atol=1e-3)
    np.testing.assert_allclose(rows, SIZE[1] - turned["projected_cuboid"].T[1], atol=1e-3)
    np.testing.assert_allclose(plain["location"] * (1, -1, -1), turned["location"], rtol=1e-5)


def test_the_given_size_scales_pixels(frame):
    own, _ = compute(frame, "dope")
    given, _ = compute(frame, "dope", width=2 * SIZE[0], height=SIZE[1])
    np.testing.assert_allclose(given["projected_cuboid"], own["projected_cuboid"] * (2, 1), rtol=1e-6)


def test_pose_lists_what_is_visible(frame):
    assert compute(frame, "pose")[1]["primPaths"] == ["/World/Mug", "/World/Stretched"]
    everything = compute(frame, "pose", includeOccludedPrims=True)[1]["primPaths"]
    assert everything == ["/World/Mug", "/World/Stretched", "/World/Behind", "/World/Aside"]


def test_pose_is_a_rigid_transform_where_the_scale_is_the_same_along_all_axes(frame):
    rows, _ = compute(frame, "pose")
    location, center = in_camera(frame, [MUG["translate"]])
    matrix = rows["prims_to_desired_camera"][0]
    np.testing.assert_allclose(matrix[:3, 3], location[0], rtol=1e-5)
    np.testing.assert_allclose(matrix[:3, :3], (camera_turn(frame) * turn_of(MUG)).as_matrix(), atol=1e-5)
    np.testing.assert_allclose(matrix[3], (0, 0, 0, 1), atol=1e-6)
    np.testing.assert_allclose(rows["center_coords_image_space"][0], center[0], atol=1e-3)


def test_pose_divides_a_stretched_transform_by_its_columns_as_isaac_sim_does(frame):
    rows, _ = compute(frame, "pose")
    rotation = turn_of(STRETCHED).as_matrix()
    local_to_world = (rotation * STRETCHED["scale"]).T  # row vectors
    lengths = [np.sqrt(sum(local_to_world[row, column] ** 2 for row in range(3))) for column in range(3)]
    divided = local_to_world.copy()
    for row, column in itertools.product(range(3), range(3)):
        divided[row, column] /= lengths[column]
    expected = camera_turn(frame).as_matrix() @ divided.T
    np.testing.assert_allclose(rows["prims_to_desired_camera"][1, :3, :3], expected, atol=1e-5)


@pytest.mark.parametrize("extension", ["omni.replicator.isaac", "isaacsim.replicator.writers"])
def test_scripts_register_them_from_the_nodes(frame, extension):
    try:
        AnnotatorRegistry.register_annotator_from_node("DopeSync", [], "omni.graph.action.RationalTimeSyncGate")
        turn = {"width": 0, "height": 0, "cameraRotation": np.array([0, 0, 0])}
        AnnotatorRegistry.register_annotator_from_node("turned", ["DopeSync"], f"{extension}.Dope", init_params=turn)
        found = annotators.get("turned", {"semanticTypes": ["class"]}).compute(frame).data
        np.testing.assert_array_equal(found, compute(frame, "dope", cameraRotation=(0, 0, 0))[0])
    finally:
        for name in ("DopeSync", "turned"):
            annotators.unregister_annotator(name)
