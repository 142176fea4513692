"""Pages over BasicWriter's folders."""

from __future__ import annotations

import numpy as np
import pytest

from tests.inspect.datasets import HEIGHT, WIDTH, BasicFolder, keypoints_in_camera, pixel
from tests.inspect.page import Page
from usdsdg.inspect import inspect

LAYOUTS = {
    "flat": "{kind}",
    "folders": "{annotator}/{kind}",
    "product": "Replicator_01/{annotator}/{kind}",
    "common": "{annotator}/Replicator_01_{kind}",
    "nested": "Replicator/cam_0_Xform/cam_0/{annotator}/{kind}",
}
VIEWS = {
    "flat": "",
    "folders": "",
    "product": "Replicator_01",
    "common": "Replicator_01",
    "nested": "Replicator/cam_0_Xform/cam_0",
}


def page(folder, **options) -> Page:
    return Page(inspect(folder, **options))


def box_row(transform, low, high, occlusion=0.0):
    return (0, *low, *high, transform, occlusion)


def shifted(x, y, z):
    matrix = np.eye(4)
    matrix[3, :3] = (x, y, z)
    return matrix


@pytest.mark.parametrize("layout", LAYOUTS)
def test_all_layouts_are_read(tmp_path, layout):
    folder = BasicFolder(tmp_path, LAYOUTS[layout])
    for frame in range(2):
        folder.rgb(frame)
        folder.boxes("bounding_box_2d_tight", frame, [(1, 3, 4, 9, 11, 0.25)])
        np.save(folder.path("pointcloud", f"_{frame:04d}.npy"), np.zeros((3, 3)))
        np.save(folder.path("pointcloud", f"_rgb_{frame:04d}.npy"), np.zeros((3, 4)))
    made = page(tmp_path)
    assert made.values["writers"] == ["BasicWriter"]
    assert made.values["views"] == [VIEWS[layout]]
    assert [frame["name"].rsplit("/", 1)[-1] for frame in made.values["frames"]] == ["0000", "0001"]
    assert made.values["unshown"] == {"pointcloud": 2, "pointcloud_rgb": 2}
    assert made.values["problems"] == []
    seen = made.values["frames"][0]["objects"][0]
    # The last pixel belongs to the box.
    assert seen["box"] == [3, 4, 10, 12]
    assert seen["size"] == pytest.approx(np.sqrt(7 * 8), abs=1e-3)
    assert seen["visibility"] == 0.75
    assert made.values["classes"][seen["class"]]["name"] == "crate"


def test_boxes_of_one_prim_are_one_object(tmp_path):
    folder = BasicFolder(tmp_path)
    folder.rgb(0)
    folder.camera(0)
    folder.boxes("bounding_box_2d_tight", 0, [(0, 3, 4, 9, 11, 0.5)], prims=["/World/mug"])
    folder.boxes(
        "bounding_box_2d_loose", 0, [(0, 1, 1, 5, 5, 0.0), (0, 3, 4, 12, 14, 0.5)], prims=["/World/far", "/World/mug"]
    )
    # Half a unit wide at the camera's (0.1, -0.05, -2); the camera stands at (1, 2, 5).
    folder.boxes(
        "bounding_box_3d", 0, [box_row(shifted(1.1, 1.95, 3.0), (-0.25,) * 3, (0.25,) * 3)], prims=["/World/mug"]
    )
    objects = page(tmp_path).frame("0000")["objects"]
    assert [each["path"] for each in objects] == ["/World/mug", "/World/far"]
    mug = objects[0]
    assert (mug["box"], mug["loose"]) == ([3, 4, 10, 12], [3, 4, 13, 15])
    expected = [pixel(point) for point in keypoints_in_camera([0.1, -0.05, -2.0], [0.5] * 3)]
    assert np.array(mug["cuboid"]) == pytest.approx(np.array(expected), abs=0.06)
    assert mug["distance"] == pytest.approx(np.linalg.norm([0.1, -0.05, -2.0]), abs=1e-3)


def test_boxes_in_space_turn_with_their_prim(tmp_path):
    folder = BasicFolder(tmp_path)
    folder.rgb(0)
    folder.camera(0, metersPerSceneUnit=0.01)
    quarter = np.array([[0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0], [1, 2, 3, 1]], float)
    folder.boxes("bounding_box_3d", 0, [box_row(quarter, (0, -0.1, -0.1), (0.4, 0.1, 0.1))])
    seen = page(tmp_path).frame("0000")["objects"][0]
    # Local +x is world +y, which is up in the picture; the box begins at the prim's origin.
    center, towards_x = seen["axes"][0], seen["axes"][1]
    assert center == pytest.approx(pixel((0.0, 0.2, -2.0)), abs=0.06)
    assert towards_x == pytest.approx(pixel((0.0, 0.4, -2.0)), abs=0.06)
    assert seen["distance"] == pytest.approx(0.01 * np.hypot(0.2, 2.0), abs=1e-3)


@pytest.mark.parametrize(("occlusion", "expected"), [(0.0, 1.0), (0.4, 0.6), (-1.0, None), (float("nan"), None)])
def test_unknown_occlusion_is_no_visibility(tmp_path, occlusion, expected):
    folder = BasicFolder(tmp_path)
    folder.rgb(0)
    folder.boxes("bounding_box_2d_tight", 0, [(0, 0, 0, 9, 9, occlusion)])
    assert page(tmp_path).frame("0000")["objects"][0].get("visibility") == (
        None if expected is None else pytest.approx(expected, abs=1e-3)
    )


def test_depth_is_colored_from_near_to_far(tmp_path):
    folder = BasicFolder(tmp_path)
    folder.rgb(0)
    values = np.full((HEIGHT, WIDTH), 4.0)
    values[:, : WIDTH // 2] = 0.5
    values[: HEIGHT // 4] = np.inf
    folder.depth(0, values)
    made = page(tmp_path)
    layer = made.frame("0000")["layers"]["distance_to_camera"]
    assert layer["values"] == [0.5, 4.0]
    shown = np.asarray(made.image(layer["image"]).convert("RGB")).astype(int)
    nothing, near, far = shown[3, 32], shown[30, 8], shown[30, 56]
    assert nothing.max() < 25
    assert near[0] > near[2] + 50
    assert far[2] > far[0]


def test_masks_keep_their_colors_and_shrink_by_whole_steps(tmp_path):
    folder = BasicFolder(tmp_path)
    folder.rgb(0)
    mask = np.zeros((HEIGHT, WIDTH, 4), np.uint8)
    mask[10:20, 10:20] = (93, 220, 11, 255)
    mask[30:40, 30:40] = (243, 69, 141, 255)
    folder.mask(0, mask)
    made = page(tmp_path)
    shown = np.asarray(made.image(made.frame("0000")["layers"]["semantic_segmentation"]["image"]).convert("RGBA"))
    assert np.array_equal(shown, mask)


def test_plain_ids_get_colors_of_their_own(tmp_path):
    folder = BasicFolder(tmp_path)
    folder.rgb(0)
    ids = np.zeros((HEIGHT, WIDTH), np.uint16)
    ids[10:20], ids[20:30], ids[30:40] = 1, 2, 60000
    folder.mask(0, ids)
    made = page(tmp_path)
    shown = np.asarray(made.image(made.frame("0000")["layers"]["semantic_segmentation"]["image"]).convert("RGBA"))
    assert shown[5, 5, 3] == 0
    assert len({tuple(shown[row, 5]) for row in (5, 15, 25, 35)}) == 4


def test_what_some_frames_lack_is_a_problem(tmp_path):
    folder = BasicFolder(tmp_path)
    for frame in range(5):
        folder.rgb(frame)
        folder.boxes("bounding_box_2d_tight", frame, [(0, 0, 0, 9, 9, 0.0)] if frame else [])
    folder.path("rgb", "_0001.png").unlink()
    folder.path("bounding_box_2d_tight", "_0002.npy").unlink()
    folder.path("bounding_box_2d_tight", "_labels_0003.json").unlink()
    folder.path("bounding_box_2d_tight", "_0004.npy").write_bytes(b"\x93NUMPY broken")
    told = page(tmp_path).problems()
    assert told["labels without picture"] == ["bounding_box_2d_tight_0001.npy: there is no picture of it"]
    assert told["picture without labels"] == ["rgb_0002.png: there are no labels of it"]
    assert told["missing file"] == ["bounding_box_2d_tight_labels_0003.json: is missing"]
    assert told["unreadable file"][0].startswith("bounding_box_2d_tight_0004.npy: ")
    assert told["empty frame"] == ["0000: no object in view"]
    # Each problem is listed once.
    assert sum(map(len, told.values())) == 5


def test_odd_boxes_are_problems(tmp_path):
    folder = BasicFolder(tmp_path)
    folder.rgb(0)
    folder.boxes("bounding_box_2d_tight", 0, [(5, 0, 0, 9, 9, 0.0), (0, 60, 0, 70, 9, 0.0)])
    told = page(tmp_path).problems()
    text = "bounding_box_2d_tight_0000.npy: a box has id 5, which the labels file does not know"
    assert told["odd labels"] == [text]
    assert told["box outside the picture"] == ["0000: the box of /World/thing_1 reaches outside the picture"]


def test_cuboids_without_a_camera_are_explained(tmp_path):
    folder = BasicFolder(tmp_path)
    folder.rgb(0)
    folder.boxes("bounding_box_3d", 0, [box_row(shifted(1, 2, 3), (-1,) * 3, (1,) * 3)])
    made = page(tmp_path)
    assert "cuboid" not in made.frame("0000")["objects"][0]
    assert any("camera_params is missing" in note for note in made.values["notes"])


def test_layers_of_another_size_are_problems(tmp_path):
    folder = BasicFolder(tmp_path)
    folder.rgb(0)
    folder.depth(0, np.ones((HEIGHT // 2, WIDTH // 2)))
    assert (
        "distance_to_camera_0000.npy is 32 x 24, the picture 64 x 48 pixels"
        in page(tmp_path).problems()["sizes differ"][0]
    )


def equidistant(points) -> np.ndarray:
    """Pixels of points in the frame of a fisheye with 60 degrees from the axis to the left and right edge."""
    x, y, z = np.asarray(points, float).T
    across = np.hypot(x, y)
    radius = np.degrees(np.arctan2(across, -z)) / 60.0 * WIDTH / 2
    return np.stack([WIDTH / 2 + radius * x / across, HEIGHT / 2 - radius * y / across], axis=1)


def test_edges_of_boxes_bend_with_the_lens(tmp_path):
    folder = BasicFolder(tmp_path)
    folder.rgb(0)
    lens = dict(
        cameraModel="fisheyeEquidistant", cameraFocalLength=10.0 / np.tan(np.radians(60)), cameraApertureOffset=[0, 0],
        cameraFisheyeOpticalCentre=[0, 0], cameraFisheyeNominalWidth=0, cameraFisheyeNominalHeight=0,
        cameraFisheyeMaxFOV=200.0, cameraFisheyePolynomial=[0] * 5, cameraFisheyeLensP=[0] * 2,
        cameraFisheyeLensS=[0] * 4,
    )  # fmt: skip
    folder.camera(0, **lens)
    # The camera stands at (1, 2, 5).
    folder.boxes("bounding_box_3d", 0, [box_row(shifted(1.5, 2.3, 4.0), (-0.25,) * 3, (0.25,) * 3)])
    seen = page(tmp_path).frame("0000")["objects"][0]
    assert "cuboid" not in seen
    ends = np.array(seen["edges"]).reshape(-1, 2)
    corners = np.array(keypoints_in_camera([0.5, 0.3, -1.0], [0.5] * 3))[1:]
    for corner in equidistant(corners):
        assert np.abs(ends - corner).max(axis=1).min() < 0.06
    middle = equidistant([corners[:2].mean(axis=0)])
    # A straight line between the corners would miss the middle of their edge.
    assert np.abs(equidistant(corners[:2]).mean(axis=0) - middle).max() > 0.1
    assert np.abs(ends - middle).max(axis=1).min() < 0.06
    assert seen["axes"][0] == pytest.approx(equidistant([(0.5, 0.3, -1.0)])[0], abs=0.06)
