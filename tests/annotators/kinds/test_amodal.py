"""Hidden pixels and who hides them, against masks of one thing at a time."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from tests.annotators.ray_caster import RayCaster, add_cube, make_frame, new_stage, rays
from tests.annotators.scenes import crowds, street
from usdsdg import annotators
from usdsdg.errors import AnnotatorError


@pytest.fixture(scope="module")
def frame():
    return make_frame(street())


def compute(frame, name, **params) -> Any:
    return annotators.get(name, init_params=params).compute(frame)


def masks_alone(stage, frame) -> dict[str, np.ndarray]:
    """Prim path → (H, W) bool, of labeled gprims that cover something alone."""
    caster, (origins, directions) = RayCaster(stage), rays(frame.camera)
    near_and_far = frame.camera.clipping_range
    hits = [caster._intersect(k, origins, directions, near_and_far)[0] for k in range(len(caster.gprims))]
    masks = {path: np.isfinite(hit).reshape(frame.shape) for path, hit in zip(caster.gprims, hits)}
    return {path: mask for path, mask in masks.items() if path in frame.labeled_prims.prim_paths and mask.any()}


def seen_in(frame) -> np.ndarray:
    """(H, W) prim path of what each pixel shows; "" for nothing."""
    return np.array([*frame.gprims, ""])[frame.aov("instance")]


def decoded(run_lengths) -> np.ndarray:
    flat = np.repeat(np.arange(len(run_lengths["counts"])) % 2 == 1, run_lengths["counts"])
    return flat.reshape(run_lengths["size"], order="F")


def check(stage, frame):
    masks, seen = masks_alone(stage, frame), seen_in(frame)
    stack, runs = (
        compute(frame, "amodal_instance_segmentation"),
        compute(frame, "amodal_instance_segmentation", encoding="rle"),
    )
    assert stack.info["primPaths"] == runs.info["primPaths"] == list(masks)
    assert stack.data.shape == (len(masks), *frame.shape)
    for path, mask, lengths in zip(masks, stack.data, runs.info["masks"]):
        np.testing.assert_array_equal(mask, masks[path])
        np.testing.assert_array_equal(decoded(lengths), masks[path])
        assert sum(lengths["counts"]) == mask.size
    info = compute(frame, "visibility")
    names, path_of = info.info["idToLabels"], dict(zip(info.data["instanceId"].tolist(), info.info["primPaths"]))
    assert list(path_of.values()) == list(masks)
    labeled = set(frame.labeled_prims.prim_paths)
    expected_pairs = {}
    for row, hidden_by in zip(info.data, info.info["hiddenBy"]):
        path = path_of[int(row["instanceId"])]
        mask = masks[path]
        y, x = np.nonzero(mask)
        assert (row["visiblePixels"], row["amodalPixels"]) == ((seen == path).sum(), mask.sum())
        assert [row[name] for name in ("x_min", "y_min", "x_max", "y_max")] == [x.min(), y.min(), x.max(), y.max()]
        assert row["visibleRatio"] == pytest.approx((seen == path).sum() / mask.sum())
        others, pixels = np.unique(
            [p if p in labeled else "UNLABELLED" for p in seen[mask & (seen != path)]], return_counts=True
        )
        assert {names[occluder]: n for occluder, n in hidden_by.items()} == dict(zip(others.tolist(), pixels.tolist()))
        expected_pairs |= {(other, path): n for other, n in zip(others.tolist(), pixels.tolist())}
    graph = compute(frame, "occlusion_graph")
    names = graph.info["idToLabels"]
    found = {(names[str(a)], names[str(b)]): n for a, b, n in graph.data.tolist()}
    assert found == expected_pairs
    assert len(found) == len(graph.data)


def test_the_street(frame):
    check(street(), frame)
    rows = compute(frame, "visibility")
    hidden = rows.info["primPaths"].index("/World/Hidden")
    assert rows.data["visiblePixels"][hidden] == 0
    assert [rows.info["idToLabels"][key] for key in rows.info["hiddenBy"][hidden]] == ["/World/Pear"]
    assert "/World/Outside" not in rows.info["primPaths"]
    json.dumps([rows.info["hiddenBy"], compute(frame, "amodal_instance_segmentation", encoding="rle").info["masks"]])


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(stage=crowds())
def test_crowds(stage):
    check(stage, make_frame(stage, (48, 36)))


def test_ids_are_those_of_the_segmentations(frame):
    instances = compute(frame, "instance_segmentation")
    rows = compute(frame, "visibility")
    for id_, path in zip(rows.data["instanceId"].tolist(), rows.info["primPaths"]):
        if str(id_) in instances.info["idToLabels"]:
            assert instances.info["idToLabels"][str(id_)] == path
    occlusion = compute(frame, "occlusion").data
    occlusion = occlusion[~np.isnan(occlusion["occlusionRatio"])]  # those in view
    np.testing.assert_array_equal(rows.data["instanceId"], occlusion["instanceId"])
    np.testing.assert_array_equal(rows.data["semanticId"], occlusion["semanticId"])
    np.testing.assert_allclose(1 - rows.data["visibleRatio"], occlusion["occlusionRatio"], atol=1e-6)


def test_a_filter_makes_the_rest_unlabeled(frame):
    rows = compute(frame, "visibility", semanticFilter="class:apple")
    assert rows.info["primPaths"] == ["/World/Apple1", "/World/Apple2"]
    assert [set(hidden_by) for hidden_by in rows.info["hiddenBy"]] == [set(), {"1"}]
    assert rows.info["idToLabels"]["1"] == "UNLABELLED"
    (pair,) = compute(frame, "occlusion_graph", semanticFilter="class:apple").data
    assert pair["occluderId"] == 1
    assert pair["pixels"] == rows.data["amodalPixels"][1] - rows.data["visiblePixels"][1]


def test_nothing_in_view():
    empty = make_frame(new_stage(), (20, 16))
    assert compute(empty, "amodal_instance_segmentation").data.shape == (0, 16, 20)
    assert len(compute(empty, "visibility").data) == len(compute(empty, "occlusion_graph").data) == 0


def test_a_mask_that_begins_and_ends_inside_has_an_empty_first_run():
    stage = new_stage()
    add_cube(stage, "/World/Wall", "wall", size=50, translate=(0, 0, -30))
    (mask,) = compute(make_frame(stage, (6, 4)), "amodal_instance_segmentation", encoding="rle").info["masks"]
    assert mask == {"size": [4, 6], "counts": [0, 24]}


def test_unknown_encodings_are_refused(frame):
    with pytest.raises(AnnotatorError, match="'png'; it may be 'stack' or 'rle'"):
        compute(frame, "amodal_instance_segmentation", encoding="png")
