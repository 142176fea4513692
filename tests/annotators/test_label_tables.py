"""Ids and colors of classes and objects over many frames in which things are hidden, removed and added."""

import numpy as np
import pytest
from pxr import UsdGeom

from tests.annotators.ray_caster import add_cube, make_frame, new_stage
from tests.annotators.scenes import mask_of
from usdsdg import annotators
from usdsdg.annotators import LabeledPrimReader

NAMES = ["plum", "apple", "pear", "fig"]


@pytest.fixture
def stage():
    stage = new_stage()
    for index, name in enumerate(NAMES):
        add_cube(stage, f"/World/{name}", name, translate=(index - 1.5, 0, 0), scale=(0.7, 0.7, 0.7))
    return stage


def compute(frame, name, **params):
    return annotators.get(name, init_params=params).compute(frame)


def seen_in(frame, name):
    """Return id and color of the class, and id of the object, that the pixels of a cube have; None out of view."""
    mask = mask_of(frame, f"/World/{name}") if f"/World/{name}" in frame.gprims else np.zeros(1, bool)
    if not mask.any():
        return None
    found = (
        compute(frame, "semantic_segmentation").data[mask],
        compute(frame, "semantic_segmentation", colorize=True).data[mask],
        compute(frame, "instance_segmentation").data[mask],
    )
    assert all((values == values[0]).all() for values in found)
    return int(found[0][0]), tuple(found[1][0].tolist()), int(found[2][0])


def test_hidden_removed_and_added_things_change_no_id(stage):
    reader, draw = LabeledPrimReader(stage), np.random.default_rng(1)
    values: dict[str, set] = {name: set() for name in NAMES}
    for index in range(30):
        for name in NAMES:
            prim = stage.GetPrimAtPath(f"/World/{name}")
            prim.SetActive(bool(draw.random() < 0.8))
            if prim.IsActive():
                show = draw.random() < 0.7
                UsdGeom.Imageable(prim).GetVisibilityAttr().Set("inherited" if show else "invisible")
        if index == 10:
            add_cube(stage, "/Added", "lemon", translate=(0, 1.5, 0))
        frame = make_frame(stage, (64, 48), reader=reader)
        for name in NAMES:
            values[name].add(seen_in(frame, name))
    assert all(len(found - {None}) == 1 for found in values.values())
    distinct = {found for each in values.values() for found in each - {None}}
    assert len({ids for ids, _, _ in distinct}) == len({colors for _, colors, _ in distinct}) == len(NAMES)


def test_what_is_hidden_at_first_has_the_id_that_it_would_have(stage):
    def ids(hidden):
        for name in NAMES:
            show = "invisible" if name in hidden else "inherited"
            UsdGeom.Imageable(stage.GetPrimAtPath(f"/World/{name}")).GetVisibilityAttr().Set(show)
        frame = make_frame(stage, (64, 48))
        return {name: seen_in(frame, name) for name in NAMES if name not in hidden}

    # As in two processes that hide different things.
    first, second = ids(["plum", "pear"]), ids(["apple"])
    everything = ids([])
    assert first.items() <= everything.items()
    assert second.items() <= everything.items()
    assert sorted(everything, key=everything.__getitem__) == sorted(NAMES)  # in the order of the names
    assert everything["apple"][0] == 2


def test_ids_of_box_lists_have_no_gaps(stage):
    stage.GetPrimAtPath("/World/plum").SetActive(False)
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/pear")).GetVisibilityAttr().Set("invisible")
    boxes = compute(make_frame(stage, (64, 48)), "bounding_box_2d_tight_fast")
    assert boxes.data["semanticId"].tolist() == [0, 1]
    assert boxes.info["idToLabels"] == {0: {"class": "apple"}, 1: {"class": "fig"}}


def test_tables_list_background_and_unlabelled_even_where_no_pixel_has_them(stage):
    ground = add_cube(stage, "/World/Ground", scale=(50, 50, 0.1), translate=(0, 0, -3))
    for pixels in ((64, 48), (8, 6)):
        frame = make_frame(stage, pixels)
        assert compute(frame, "semantic_segmentation").info["idToLabels"]["0"] == {"class": "BACKGROUND"}
        assert compute(frame, "instance_segmentation").info["idToLabels"]["1"] == "UNLABELLED"
        assert compute(frame, "instance_segmentation_fast").info["idToSemantics"][0] == {"class": "BACKGROUND"}
        assert compute(frame, "instance_id_segmentation").info["idToLabels"]["0"] == "INVALID"
    ground.SetActive(False)
    frame = make_frame(stage, (64, 48))
    assert compute(frame, "semantic_segmentation").info["idToLabels"]["1"] == {"class": "UNLABELLED"}
