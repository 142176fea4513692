"""What every registered annotator promises."""

import dataclasses

import numpy as np
import pytest
from pxr import Sdf

from tests.annotators.ray_caster import CAMERA, known, make_frame, new_stage
from tests.annotators.scenes import add_camera, street
from usdsdg import annotators
from usdsdg.session import stage_context
from usdsdg.stage.cameras import render_products
from usdsdg.stage.geometry.pixel_masks import Outlines

NAMES = annotators.get_registered_annotators()
PICTURE = {"LdrColor", "HdrColor"}
# Those that say nothing without.
PARAMS = {"Attribute": {"prims": [CAMERA], "attribute": "focalLength"}}
# The clock on the wall does not repeat.
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
    """A nested payload with arrays as tuples, to compare by value."""
    if isinstance(value, dict):
        return {key: tree(item) for key, item in value.items()}
    return (value.dtype, value.shape, value.tobytes()) if isinstance(value, np.ndarray) else value


@pytest.mark.parametrize("name", REPEATING)
def test_it_needs_no_more_than_it_declares(name, frame):
    annotator = get(name)
    given = set(annotator.aovs) | (PICTURE if annotator.needs_path_tracing else set())
    masks = frame.amodal_masks if annotator.needs_amodal_masks else Outlines.nothing(frame.shape)
    bare = dataclasses.replace(
        frame, aovs={k: v for k, v in frame.aovs.items() if k in given}, amodal_masks=masks, memo={}
    )
    assert tree(annotator.compute(bare).flat()) == tree(get(name).compute(frame).flat())


@pytest.mark.parametrize("name", REPEATING)
def test_it_leaves_the_frame_alone_and_repeats(name, frame):
    before = tree(dict(frame.aovs))
    first = tree(get(name).compute(dataclasses.replace(frame, memo={})).flat())
    again = tree(get(name).compute(dataclasses.replace(frame, memo={})).flat())
    assert first == again
    assert tree(dict(frame.aovs)) == before


@pytest.mark.parametrize("name", NAMES)
def test_its_empty_array_is_of_the_type_of_the_full_one(name, frame):
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
def test_it_is_documented(name):
    assert get(name).documentation
