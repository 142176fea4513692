"""Contract of every registered annotator."""

import dataclasses

import numpy as np
import pytest
from pxr import Sdf

from tests.annotators.ray_caster import CAMERA, known, make_frame, new_stage
from tests.annotators.scenes import add_camera, street
from usdsdg import annotators
from usdsdg.session import render_products, stage_context
from usdsdg.stage.geometry.pixel_masks import PixelMasks

NAMES = annotators.get_registered_annotators()
IMAGE = {"LdrColor", "HdrColor"}
# Parameters without which an annotator returns nothing.
PARAMS = {"Attribute": {"prims": [CAMERA], "attribute": "focalLength"}}
# The system time differs at every call.
REPEATING = [name for name in NAMES if name != "IsaacReadSystemTime"]


@pytest.fixture(scope="module", params=["full", "empty"])
def frame(request):
    stage = stage_context.set_stage(street() if request.param == "full" else new_stage())
    other = add_camera(stage, "/World/Other", (0.5, 0, 10), (0.5, 0.01, 0))
    render_products.add(render_products.HydraTexture("/Render/Other", other, (20, 16)))
    stage.GetPrimAtPath(CAMERA).CreateAttribute("crossCameraReferenceName", Sdf.ValueTypeNames.String).Set("Other")
    yield make_frame(stage, (20, 16))
    render_products.reset()


def get(name):
    return annotators.get(name, PARAMS.get(name))


def tree(value):
    """Convert a nested payload to tuples, which compare by value."""
    if isinstance(value, dict):
        return {key: tree(item) for key, item in value.items()}
    return (value.dtype, value.shape, value.tobytes()) if isinstance(value, np.ndarray) else value


@pytest.mark.parametrize("name", REPEATING)
def test_an_annotator_uses_only_the_aovs_that_it_declares(name, frame):
    annotator = get(name)
    given = set(annotator.aovs) | (IMAGE if annotator.needs_path_tracing else set())
    masks = frame.amodal_masks if annotator.needs_amodal_masks else PixelMasks.nothing(frame.shape)
    bare = dataclasses.replace(
        frame, aovs={k: v for k, v in frame.aovs.items() if k in given}, amodal_masks=masks, memo={}
    )
    assert tree(annotator.compute(bare).flat()) == tree(get(name).compute(frame).flat())


@pytest.mark.parametrize("name", REPEATING)
def test_an_annotator_does_not_change_the_frame_and_repeats_its_result(name, frame):
    before = tree(dict(frame.aovs))
    first = tree(get(name).compute(dataclasses.replace(frame, memo={})).flat())
    again = tree(get(name).compute(dataclasses.replace(frame, memo={})).flat())
    assert first == again
    assert tree(dict(frame.aovs)) == before


@pytest.mark.parametrize("name", NAMES)
def test_data_before_the_first_frame_are_empty_arrays_of_the_same_type(name, frame):
    annotator = get(name).attach(known("/Render/Any"))
    try:
        empty = annotator.get_data()
        full = annotator.compute(frame).data
        if full is None:
            assert empty == {}
        else:
            assert (empty.dtype, empty.size) == (full.dtype, 0)
    finally:
        annotator.detach()


@pytest.mark.parametrize("name", NAMES)
def test_every_annotator_is_documented(name):
    assert get(name).documentation
