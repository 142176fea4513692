"""Pages over PoseWriter's folders."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.inspect.datasets import keypoints_in_camera, picture, pixel, pose_object, write_pose
from tests.inspect.page import Page
from usdsdg.errors import DatasetError
from usdsdg.inspect import inspect

MUG = ([0.1, -0.05, -2.0], [0.2, 0.3, 0.4])


def page(folder, **options) -> Page:
    return Page(inspect(folder, **options))


@pytest.mark.parametrize("style", [None, "dope", "centerpose"])
def test_every_format_shows_the_cuboid_where_the_camera_sees_it(tmp_path, style):
    write_pose(tmp_path, 0, [pose_object(style, "mug", *MUG, visibility=0.75)], style)
    made = page(tmp_path)
    assert made.values["writers"] == [f"PoseWriter, {style or 'default'} format"]
    seen = made.frame("000000")["objects"][0]
    expected = np.array([pixel(point) for point in keypoints_in_camera(*MUG)])
    # DOPE tells whole pixels only.
    assert np.array(seen["cuboid"]) == pytest.approx(expected, abs=0.51 if style == "dope" else 0.051)
    assert seen["distance"] == pytest.approx(np.linalg.norm(MUG[0]), abs=1e-3)
    assert (seen["visibility"], seen["truncation"], seen["path"]) == (0.75, 0.0, "/World/mug")


@pytest.mark.parametrize("style", [None, "dope"])
def test_axes_point_to_the_middles_of_the_faces(tmp_path, style):
    write_pose(tmp_path, 0, [pose_object(style, "mug", *MUG)], style)
    axes = np.array(page(tmp_path).frame("000000")["objects"][0]["axes"])
    center, size = np.array(MUG[0]), np.array(MUG[1])
    ends = [center, *(center + np.eye(3)[axis] * size[axis] / 2 for axis in range(3))]
    assert axes == pytest.approx(np.array([pixel(end) for end in ends]), abs=1.0 if style == "dope" else 0.06)


def test_whole_boxes_end_at_the_pictures_edge(tmp_path):
    write_pose(tmp_path, 0, [pose_object(None, "mug", [-0.9, 0.0, -2.0], [0.4, 0.4, 0.4])])
    left, top, right, bottom = page(tmp_path).frame("000000")["objects"][0]["loose"]
    # The near face, 1.8 m away, bounds the box: its right edge lies at 32 - 80 * 0.7 / 2.2 of the far face.
    assert left == 0.0
    assert right == pytest.approx(32 - 80 * 0.7 / 2.2, abs=0.06)
    assert (top, bottom) == (pytest.approx(24 - 80 * 0.2 / 1.8, abs=0.06), pytest.approx(24 + 80 * 0.2 / 1.8, abs=0.06))


def test_a_cuboid_that_reaches_behind_the_camera_is_cut(tmp_path):
    write_pose(tmp_path, 0, [pose_object(None, "beam", [0.0, 0.3, -1.0], [0.2, 0.2, 4.0])])
    seen = page(tmp_path).frame("000000")["objects"][0]
    assert "cuboid" not in seen
    # The four edges of the far face stay whole; the four behind the camera are gone.
    assert len(seen["edges"]) == 8
    far = {pixel((x, y, -3.0)) for x in (-0.1, 0.1) for y in (0.2, 0.4)}
    ends = np.array(seen["edges"]).reshape(-1, 2)
    for corner in far:
        assert np.abs(ends - corner).max(axis=1).min() < 0.06


def test_something_wholly_behind_the_camera_draws_nothing(tmp_path):
    write_pose(tmp_path, 0, [pose_object(None, "beam", [0.0, 0.0, 3.0], [1.0, 1.0, 1.0])])
    seen = page(tmp_path).frame("000000")["objects"][0]
    assert not {"cuboid", "edges", "axes", "loose"} & seen.keys()


def test_distances_of_dope_files_are_left_out_where_they_do_not_project_to_the_objects(tmp_path):
    for number in range(4):
        write_pose(tmp_path, number, [pose_object("dope", "mug", *MUG, location=[1.0, -0.5, -2.0])], "dope")
    made = page(tmp_path)
    assert "distance" not in made.frame("000000")["objects"][0]
    assert "distance" not in {histogram["key"] for histogram in made.values["histograms"]}
    assert any("no usable distance" in note for note in made.values["notes"])


def test_subfolders_are_render_products(tmp_path):
    for view in ("Replicator", "Replicator_01"):
        for number in range(2):
            write_pose(tmp_path / view, number, [])
    made = page(tmp_path)
    assert made.values["views"] == ["Replicator", "Replicator_01"]
    assert [frame["name"] for frame in made.values["frames"]] == [
        f"{view}/{number:06d}" for view in ("Replicator", "Replicator_01") for number in range(2)
    ]


def test_counts_and_histograms_are_of_all_objects(tmp_path):
    for number in range(10):
        objects = [pose_object(None, "mug", [0.0, 0.0, -1.0 - 0.1 * number], [0.1] * 3, visibility=0.1 * number)]
        if number % 2:
            objects.append(pose_object(None, "crate", [0.2, 0.0, -2.0], [0.1] * 3))
        write_pose(tmp_path, number, objects)
    made = page(tmp_path)
    assert [(each["name"], each["objects"], each["frames"]) for each in made.values["classes"]] == [
        ("mug", 10, 10),
        ("crate", 5, 5),
    ]
    charts = {each["key"]: each for each in made.values["histograms"]}
    assert charts.keys() == {"size", "distance", "visibility", "truncation", "objects"}
    for key in ("size", "distance", "visibility"):
        assert sum(charts[key]["counts"]["mug"]) == 10
        assert sum(charts[key]["counts"]["crate"]) == 5
        assert len(charts[key]["edges"]) == len(charts[key]["counts"]["mug"]) + 1
    # One mug per twentieth of visibility that a tenth falls into.
    assert [count for count in charts["visibility"]["counts"]["mug"] if count] == [1] * 10
    assert charts["objects"]["counts"][""][1:3] == [5, 5]
    assert charts["distance"]["edges"][0] == 0.0
    assert charts["distance"]["edges"][-1] >= np.hypot(0.2, 2.0)


def test_problems_are_listed(tmp_path):
    for number in range(8):
        write_pose(tmp_path, number, [pose_object(None, "mug", *MUG)] if number != 7 else [])
    (tmp_path / "000001.json").write_text('{"objects": [')
    (tmp_path / "000002.json").unlink()
    (tmp_path / "000003.png").unlink()
    (tmp_path / "000004.png").unlink()
    (tmp_path / "000004.json").unlink()
    whole = (tmp_path / "000005.png").read_bytes()
    (tmp_path / "000005.png").write_bytes(whole[: len(whole) // 2])
    values = json.loads((tmp_path / "000006.json").read_text())
    del values["objects"][0]["cuboid_keypoints_camera_frame"]
    (tmp_path / "000006.json").write_text(json.dumps(values))
    made = page(tmp_path)
    told = made.problems()
    assert told == {
        "unreadable file": [
            "000001.json: is not valid JSON at line 1: Expecting value",
            "000006.json: is not as its format has it: 'cuboid_keypoints_camera_frame' is missing",
            "000005.png: image file is truncated",
        ],
        "picture without labels": ["000002.png: there are no labels of it"],
        "labels without picture": ["000003.json: there is no picture of it"],
        "gap in the numbers": ["1 frame number between the first and the last has no files: 4"],
        "empty frame": ["000007: no object in view"],
    }
    assert made.frame("000001")["labeled"] is False
    assert made.frame("000005")["picture"] is None
    # The rest of a broken dataset is still shown.
    assert len(made.frame("000000")["objects"]) == 1


def test_a_sound_dataset_has_no_problems(tmp_path):
    for number in range(3):
        write_pose(tmp_path, number, [pose_object(None, "mug", *MUG)])
        picture(tmp_path / f"{number:06d}_overlay.png")
    (tmp_path / "metadata.txt").write_text('{"name": "PoseWriter", "version": "0.2.0", "replicator_global_seed:": 7}')
    made = page(tmp_path)
    assert made.values["problems"] == []
    assert made.values["notes"] == []
    assert made.values["metadata"]["replicator_global_seed:"] == 7
    assert len(made.values["frames"]) == 3


@pytest.mark.parametrize("style", [None, "centerpose"])
def test_keypoints_of_another_lens_are_taken_from_the_picture(tmp_path, style):
    seen_by_fisheye = pose_object(style, "mug", *MUG)
    key = "projected_cuboid" if style else "cuboid_keypoints_projected"
    seen_by_fisheye[key] = [[10 + 2 * k, 30 - k] for k in range(9)]
    write_pose(tmp_path, 0, [seen_by_fisheye], style)
    seen = page(tmp_path).frame("000000")["objects"][0]
    assert sorted(map(tuple, seen["cuboid"])) == [(10.0 + 2 * k, 30.0 - k) for k in range(9)]


def test_files_of_a_users_writer_with_such_names_are_not_taken_for_poses(tmp_path):
    picture(tmp_path / "0000.png")
    (tmp_path / "0000.json").write_text('{"rings": 8, "depths": [0, 1]}')
    with pytest.raises(DatasetError, match="nothing in"):
        inspect(tmp_path)
