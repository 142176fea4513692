import json
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from pxr import UsdSemantics

from tests.annotators.ray_caster import add_cube, make_frame, new_stage
from tests.annotators.scenes import crowds, mask_of, street
from usdsdg import annotators
from usdsdg.annotators.colors import colors_of_ids
from usdsdg.errors import AnnotatorError, UsdsdgWarning
from usdsdg.stage.semantics.labels import add_labels


@pytest.fixture(scope="module")
def frame():
    return make_frame(street())


def compute(frame, name, **params) -> Any:
    return annotators.get(name, init_params=params).compute(frame)


def test_equal_labels_share_a_semantic_id(frame):
    seen = compute(frame, "semantic_segmentation")
    ids = seen.data
    assert ids.dtype == np.uint32
    (apple,) = np.unique(ids[mask_of(frame, "/World/Apple1")])
    assert np.unique(ids[mask_of(frame, "/World/Apple2")]) == [apple]
    (pear,) = np.unique(ids[mask_of(frame, "/World/Pear")])
    assert seen.info["idToLabels"] == {
        "0": {"class": "BACKGROUND"},
        "1": {"class": "UNLABELLED"},
        str(apple): {"class": "apple"},
        str(pear): {"class": "pear"},
    }


def test_what_has_no_label_is_1_and_nothing_is_0(frame):
    ids = compute(frame, "semantic_segmentation").data
    assert (ids[mask_of(frame, "/World/Ground")] == 1).all()
    assert (ids[frame.aovs["instance"] < 0] == 0).all()
    assert not (ids[frame.aovs["instance"] >= 0] == 0).any()


def test_a_label_that_the_filter_drops_is_unlabeled(frame):
    ids = compute(frame, "semantic_segmentation", semanticFilter="class: pear").data
    assert (ids[mask_of(frame, "/World/Apple1")] == 1).all()
    assert (ids[mask_of(frame, "/World/Pear")] >= 2).all()


def test_instances_are_told_apart_and_named(frame):
    seen = compute(frame, "instance_segmentation_fast")
    for path in ("/World/Apple1", "/World/Apple2", "/World/Pear"):
        (identifier,) = np.unique(seen.data[mask_of(frame, path)])
        assert seen.info["idToLabels"][int(identifier)] == path
        assert seen.info["idToSemantics"][int(identifier)] == {
            "class": path.removeprefix("/World/").rstrip("12").lower()
        }
    assert seen.info["idToLabels"][1] == "UNLABELLED"


def test_instance_ids_name_every_gprim_labeled_or_not(frame):
    seen = compute(frame, "instance_id_segmentation")
    (ground,) = np.unique(seen.data[mask_of(frame, "/World/Ground")])
    assert seen.info["idToLabels"][str(ground)] == "/World/Ground"
    assert "/World/Outside" not in seen.info["idToLabels"].values()


@pytest.mark.parametrize("name", ["semantic_segmentation", "instance_segmentation", "instance_id_segmentation"])
def test_colorized_and_plain_tell_the_same(frame, name):
    plain, colored = compute(frame, name), compute(frame, name, colorize=True)
    assert colored.data.dtype == np.uint8
    assert colored.data.shape == (*plain.data.shape, 4)
    for identifier, described in plain.info["idToLabels"].items():
        color = colors_of_ids(np.array([int(identifier)]))[0]
        key = str(tuple(color.tolist()))
        assert colored.info["idToLabels"][key] == described
        assert (colored.data[plain.data == int(identifier)] == color).all()
    keys = [json.loads(key.replace("(", "[").replace(")", "]")) for key in colored.info["idToLabels"]]
    assert keys == sorted(keys)


def test_fast_colorized_tables_have_tuples_as_keys(frame):
    keys = compute(frame, "instance_segmentation_fast", colorize=True).info["idToLabels"]
    assert (0, 0, 0, 255) in keys


def test_mapping_chooses_ids_and_colors(frame):
    mapping = {"class:apple": [9, 8, 7, 255], "class:pear": 40}
    ids = compute(frame, "semantic_segmentation", mapping=json.dumps(mapping))
    assert (ids.data[mask_of(frame, "/World/Pear")] == 40).all()
    assert ids.info["idToLabels"]["40"] == {"class": "pear"}
    image = compute(frame, "semantic_segmentation", mapping=mapping, colorize=True)
    assert (image.data[mask_of(frame, "/World/Apple1")] == (9, 8, 7, 255)).all()
    assert image.info["idToLabels"]["(9, 8, 7, 255)"] == {"class": "apple"}


@pytest.mark.parametrize("key", ["class:Apple", "Apple", "apple"])
@pytest.mark.parametrize("value", [np.array([9, 8, 7, 255]), [9.0, 8.0, 7.0], (np.uint8(9), np.uint8(8), np.uint8(7))])
def test_keys_and_colors_of_mappings_as_scripts_write_them(frame, key, value):
    image = compute(frame, "semantic_segmentation", mapping={key: value}, colorize=True)
    assert (image.data[mask_of(frame, "/World/Apple1")] == (9, 8, 7, 255)).all()


def test_a_mapping_may_have_ids_of_numpy_and_what_has_no_label(frame):
    ids = compute(frame, "semantic_segmentation", mapping={"Pear": np.int64(40), "UNLABELLED": 50, "BACKGROUND": 60})
    assert (ids.data[mask_of(frame, "/World/Pear")] == 40).all()
    assert (ids.data[mask_of(frame, "/World/Ground")] == 50).all()
    assert (ids.data[frame.aovs["instance"] < 0] == 60).all()
    assert {ids.info["idToLabels"][key]["class"] for key in ("40", "50", "60")} == {"pear", "UNLABELLED", "BACKGROUND"}


@pytest.mark.parametrize(
    ("mapping", "said"),
    [
        ({"class:pear": "#ff0000"}, r"mapping\['class:pear'\] is '#ff0000'; expected a color"),
        ({"class:pear": (1, 2)}, "expected a color"),
        ({"class:pear": (300, 0, 0)}, "from 0 to 255"),
        ({"class:pear": (0.5, 0, 0)}, "whole numbers"),
        ({"class:pear": -1}, "or an id"),
        ({"class:pear": 1 << 32}, "or an id"),
        ({"class:pear": True}, "or an id"),
        ({"class:pear": None}, "or an id"),
        ({7: (1, 2, 3)}, "has the key 7; expected a text"),
        ({("class", "pear"): (1, 2, 3)}, "expected a text"),
        ([("class:pear", 4)], "mapping must be"),
        ("missing.json", "cannot be read as JSON"),
    ],
)
def test_a_wrong_mapping_is_an_error_before_any_frame(mapping, said):
    with pytest.raises(AnnotatorError, match=said):
        annotators.get("semantic_segmentation", init_params={"mapping": mapping})


def test_a_warning_names_what_has_the_id_of_a_mapping(frame):
    table = compute(frame, "semantic_segmentation").info["idToLabels"]
    (taken,) = (int(key) for key, labels in table.items() if labels == {"class": "apple"})
    with pytest.warns(UsdsdgWarning, match=f"gives class:pear the id {taken}, which is that of class:apple"):
        compute(frame, "semantic_segmentation", mapping={"class:pear": taken})


def test_ids_do_not_depend_on_what_is_in_view():
    stage = new_stage()
    away = add_cube(stage, "/World/A", "apple")
    add_cube(stage, "/World/B", "pear", translate=(2, 0, 0))
    both = compute(make_frame(stage), "instance_segmentation_fast").info["idToLabels"]
    away.GetAttribute("xformOp:translate").Set((99, 0, 0))
    one = compute(make_frame(stage), "instance_segmentation_fast").info["idToLabels"]
    assert {k: v for k, v in both.items() if v == "/World/B"} == {k: v for k, v in one.items() if v == "/World/B"}
    assert "/World/A" not in one.values()


def test_an_empty_stage_is_background():
    seen = compute(make_frame(new_stage(), (8, 4)), "semantic_segmentation", colorize=True)
    assert seen.data.shape == (4, 8, 4)
    assert not seen.data.any()
    assert seen.info["idToLabels"] == {
        "(0, 0, 0, 0)": {"class": "BACKGROUND"},
        "(0, 0, 0, 255)": {"class": "UNLABELLED"},
    }


def test_labels_of_several_types_share_one_entry():
    stage = new_stage()
    add_labels(add_cube(stage, "/World/A", "apple"), {"color": ["red"]})
    seen = compute(make_frame(stage), "semantic_segmentation")
    assert seen.info["idToLabels"]["2"] == {"class": "apple", "color": "red"}


@given(stage=crowds())
@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_masks_agree_with_depth_and_with_each_other(stage):
    frame = make_frame(stage, (40, 30))
    semantic = compute(frame, "semantic_segmentation").data
    instance = compute(frame, "instance_segmentation").data
    gprim = compute(frame, "instance_id_segmentation").data
    hit = np.isfinite(frame.aovs["distance_to_camera"])
    for ids in (semantic, instance, gprim):
        np.testing.assert_array_equal(ids > 0, hit)
    np.testing.assert_array_equal(semantic > 1, instance > 1)
    # An instance has one semantic id.
    for identifier in np.unique(instance):
        assert len(np.unique(semantic[instance == identifier])) == 1


@pytest.mark.parametrize("label", ["background", "BACKGROUND", "Unlabelled", "invalid", "none"])
def test_reserved_names_are_labels_like_others(label):
    stage = new_stage()
    add_cube(stage, "/World/Cube", label)
    frame = make_frame(stage, (16, 12))
    seen = annotators.get("semantic_segmentation").compute(frame)
    table = seen.info["idToLabels"]
    (number,) = set(table) - {"0", "1"}
    assert table == {"0": {"class": "BACKGROUND"}, "1": {"class": "UNLABELLED"}, number: {"class": label.lower()}}
    assert (seen.data == int(number)).any()
    colors = annotators.get("semantic_segmentation", {"colorize": True}).compute(frame).data
    assert colors[seen.data == int(number)][:, :3].any(axis=1).all()  # not black, as the background is
    boxes = annotators.get("bounding_box_2d_tight").compute(frame)
    assert boxes.info["idToLabels"] == {"0": {"class": label.lower()}}


def test_a_label_with_a_comma_is_named_and_reads_as_several():
    stage = new_stage()
    add_cube(stage, "/World/Cube", "nut, M3")
    with pytest.warns(UsdsdgWarning, match="/World/Cube: the label 'nut, m3' has a comma"):
        frame = make_frame(stage, (16, 12))
    assert {"class": "nut, m3"} in annotators.get("semantic_segmentation").compute(frame).info["idToLabels"].values()


@pytest.mark.parametrize("label", ["", "  "])
def test_empty_labels_are_none(label):
    stage = new_stage()
    prim = add_cube(stage, "/World/Cube")
    UsdSemantics.LabelsAPI.Apply(prim, "class").CreateLabelsAttr().Set([label])
    frame = make_frame(stage, (16, 12))
    assert set(annotators.get("semantic_segmentation").compute(frame).info["idToLabels"]) == {"0", "1"}
    assert not len(annotators.get("bounding_box_2d_tight").compute(frame).data)
