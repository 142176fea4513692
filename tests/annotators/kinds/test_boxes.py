import math
from typing import Any

import numpy as np
import pytest
import warp as wp
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.annotators.ray_caster import add_cube, make_frame, new_stage
from tests.annotators.scenes import crowds, mask_of, street
from usdsdg import annotators
from usdsdg.annotators.pixels.look_ups import sum_all_by_gprim, sum_by_gprim

CORNERS = ["x_min", "y_min", "x_max", "y_max"]


@pytest.fixture(scope="module")
def frame():
    return make_frame(street())


def compute(frame, name, **params) -> Any:
    return annotators.get(name, init_params=params).compute(frame)


def by_path(annotation):
    return dict(zip(annotation.info["primPaths"], annotation.data))


def box_of_mask(mask):
    y, x = np.nonzero(mask)
    return [x.min(), y.min(), x.max(), y.max()]


def test_a_face_on_square_follows_the_inclusive_pixel_rule():
    # The near face of a unit cube, 9.5 m away, spans u = W/2 -/+ f/19 pixels.
    stage = new_stage()
    add_cube(stage, "/World/Cube", "cube", translate=(0.31, -0.17, 0))
    width, height = 320, 200
    focal = width * 24.0 / 20.955
    expected = {
        "x_min": math.ceil(width / 2 + focal * (0.31 - 0.5) / 9.5 - 0.5),
        "x_max": math.ceil(width / 2 + focal * (0.31 + 0.5) / 9.5 - 0.5) - 1,
        "y_min": math.ceil(height / 2 + focal * (0.17 - 0.5) / 9.5 - 0.5),
        "y_max": math.ceil(height / 2 + focal * (0.17 + 0.5) / 9.5 - 0.5) - 1,
    }
    for name in ("bounding_box_2d_tight", "bounding_box_2d_loose"):
        (row,) = compute(make_frame(stage, (width, height)), name).data
        assert {name: int(row[name]) for name in CORNERS} == expected


def test_tight_boxes_bound_visible_pixels_and_omit_hidden_things(frame):
    boxes = by_path(compute(frame, "bounding_box_2d_tight"))
    assert sorted(boxes) == ["/World/Apple1", "/World/Apple2", "/World/Pear"]
    for path, row in boxes.items():
        assert [row[name] for name in CORNERS] == box_of_mask(mask_of(frame, path))


def test_loose_boxes_ignore_occlusion_and_omit_what_is_out_of_view(frame):
    boxes = by_path(compute(frame, "bounding_box_2d_loose"))
    assert sorted(boxes) == ["/World/Apple1", "/World/Apple2", "/World/Hidden", "/World/Pear"]
    one, two = boxes["/World/Apple1"], boxes["/World/Apple2"]
    assert two["occlusionRatio"] > 0.1
    assert one["occlusionRatio"] == 0
    # Equal spheres at equal heights are about equally wide.
    assert abs((one["x_max"] - one["x_min"]) - (two["x_max"] - two["x_min"])) <= 2


def test_occlusion_is_the_hidden_share_of_pixels(frame):
    ratio = {path: row["occlusionRatio"] for path, row in by_path(compute(frame, "bounding_box_3d")).items()}
    labeled_prims = frame.labeled_prims
    for path, value in ratio.items():
        alone = frame.coverage[labeled_prims.prim_paths.index(path), 0]
        assert value == pytest.approx(1 - mask_of(frame, path).sum() / alone, abs=1e-6)
    assert ratio["/World/Hidden"] == 1
    assert ratio["/World/Pear"] == 0


def test_3d_boxes_list_what_is_in_view_and_360_lists_all(frame):
    assert "/World/Outside" not in by_path(compute(frame, "bounding_box_3d"))
    everywhere = by_path(compute(frame, "bounding_box_3d_360"))
    assert math.isnan(everywhere["/World/Outside"]["occlusionRatio"])
    np.testing.assert_allclose(everywhere["/World/Outside"]["transform"][3], [30, 0, 0, 1])


def test_semantic_ids_of_boxes_count_from_zero(frame):
    fast = compute(frame, "bounding_box_3d_fast")
    labels = {path: fast.info["idToLabels"][row["semanticId"]]["class"] for path, row in by_path(fast).items()}
    assert labels["/World/Apple1"] == labels["/World/Apple2"] == "apple"
    assert labels["/World/Pear"] == "pear"
    assert min(fast.info["idToLabels"]) == 0
    assert all(isinstance(key, str) for key in compute(frame, "bounding_box_3d").info["idToLabels"])


@pytest.mark.parametrize("name", ["bounding_box_2d_tight", "bounding_box_2d_loose", "bounding_box_3d"])
def test_fast_boxes_differ_in_the_keys_alone(frame, name):
    one, fast = compute(frame, name), compute(frame, f"{name}_fast")
    np.testing.assert_array_equal(one.data, fast.data)
    assert one.info["primPaths"] == fast.info["primPaths"]
    assert one.info["idToLabels"] == {str(key): labels for key, labels in fast.info["idToLabels"].items()}
    assert all(isinstance(key, int) for key in fast.info["idToLabels"])


def test_boxes_carry_the_ids_of_the_instance_segmentation(frame):
    boxes, masks = compute(frame, "bounding_box_2d_tight"), compute(frame, "instance_segmentation_fast")
    assert len(boxes.info["primPaths"]) > 0
    for path, identifier in zip(boxes.info["primPaths"], boxes.info["bboxIds"], strict=True):
        assert masks.info["idToLabels"][int(identifier)] == path


def test_occlusion_lists_all_labeled_prims_and_the_unlabeled_in_one_row(frame):
    first, *rows = compute(frame, "occlusion").data
    assert tuple(first)[:2] == (1, 1)
    assert np.isnan(first["occlusionRatio"])
    names = compute(frame, "instance_segmentation_fast").info["idToLabels"]
    labels = compute(frame, "semantic_segmentation").info["idToLabels"]
    seen = {names.get(int(row["instanceId"])): labels.get(str(row["semanticId"])) for row in rows}
    assert seen["/World/Pear"] == {"class": "pear"}
    ratios = {path: row["occlusionRatio"] for path, row in zip(frame.labeled_prims.prim_paths, rows, strict=True)}
    assert np.isnan(ratios["/World/Outside"])
    assert ratios["/World/Hidden"] == 1
    assert 0 < ratios["/World/Apple2"] < 1


def test_a_filter_drops_boxes(frame):
    assert list(by_path(compute(frame, "bounding_box_2d_loose", semanticFilter="class:pear"))) == ["/World/Pear"]


def test_types_drop_boxes(frame):
    assert len(compute(frame, "bounding_box_2d_loose", semanticTypes=["shape"]).data) == 0


@given(
    st.integers(1, 12).flatmap(
        lambda width: st.lists(st.lists(st.integers(-1, 4), min_size=width, max_size=width), min_size=1, max_size=12)
    )
)
@settings(deadline=None)
def test_pixels_and_bounds_of_gprims_equal_a_search_over_pixels(rows):
    shown = np.array(rows, np.int32)
    sums = sum_by_gprim(shown, 5)
    for gprim in range(5):
        mask = shown == gprim
        assert sums[gprim].tolist() == [mask.sum(), *(box_of_mask(mask) if mask.any() else [-1] * 4)]


@given(stage=crowds())
@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_boxes_masks_and_depth_agree(stage):
    frame = make_frame(stage, (48, 36))
    tight, loose = (by_path(compute(frame, f"bounding_box_2d_{kind}")) for kind in ("tight", "loose"))
    solid = by_path(compute(frame, "bounding_box_3d"))
    assert set(tight) <= set(loose) == set(solid)
    for path, row in tight.items():
        outer = loose[path]
        assert outer["x_min"] <= row["x_min"] <= row["x_max"] <= outer["x_max"]
        assert outer["y_min"] <= row["y_min"] <= row["y_max"] <= outer["y_max"]
        # Every seen point lies in the box: depth, camera, transform and extents tell of one scene.
        points = frame.aovs["position"][mask_of(frame, path)].astype(np.float64)
        local = np.c_[points, np.ones(len(points))] @ np.linalg.inv(solid[path]["transform"].astype(np.float64))
        low, high = ([solid[path][f"{axis}_{end}"] for axis in "xyz"] for end in ("min", "max"))
        # float32 positions of a few meters, divided by scales down to 0.2
        assert (local[:, :3] >= np.array(low) - 1e-5).all()
        assert (local[:, :3] <= np.array(high) + 1e-5).all()


def test_sums_of_many_images_are_those_of_each():
    rng = np.random.default_rng(3)
    shown = rng.integers(-1, 5, (3, 13, 70)).astype(np.int32)
    shown[1] = -1
    whole = wp.array(shown, dtype=wp.int32, device="cpu")
    images = [whole[k] for k in range(len(shown))]
    for image, sums in zip(shown, sum_all_by_gprim(images, 6), strict=True):
        np.testing.assert_array_equal(sums, sum_by_gprim(image, 6))
    apart = [images[0], images[2]]  # not one after the other
    for image, sums in zip(shown[::2], sum_all_by_gprim(apart, 6), strict=True):
        np.testing.assert_array_equal(sums, sum_by_gprim(image, 6))
