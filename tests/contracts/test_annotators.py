"""What every registered annotator promises."""

import dataclasses

import numpy as np
import pytest

from tests.annotators.ray_caster import known, make_frame, new_stage
from tests.annotators.scenes import street
from usdsdg import annotators

NAMES = [name for name in annotators.get_registered_annotators() if name != "skeleton_data"]
PICTURE = {"LdrColor", "HdrColor"}


@pytest.fixture(scope="module", params=["full", "empty"])
def frame(request):
    return make_frame(street() if request.param == "full" else new_stage(), (20, 16))


def tree(value):
    """A nested payload with arrays as tuples, to compare by value."""
    if isinstance(value, dict):
        return {key: tree(item) for key, item in value.items()}
    return (value.dtype, value.shape, value.tobytes()) if isinstance(value, np.ndarray) else value


@pytest.mark.parametrize("name", NAMES)
def test_it_needs_no_more_than_it_declares(name, frame):
    annotator = annotators.get(name)
    given = set(annotator.aovs) | (PICTURE if annotator.needs_picture else set())
    coverage = frame.coverage if annotator.needs_coverage else np.zeros((0, 5), np.int64)
    bare = dataclasses.replace(
        frame, aovs={k: v for k, v in frame.aovs.items() if k in given}, coverage=coverage, memo={}
    )
    assert tree(annotator.compute(bare).flat()) == tree(annotators.get(name).compute(frame).flat())


@pytest.mark.parametrize("name", NAMES)
def test_it_leaves_the_frame_alone_and_repeats(name, frame):
    before = tree(dict(frame.aovs))
    first = tree(annotators.get(name).compute(dataclasses.replace(frame, memo={})).flat())
    again = tree(annotators.get(name).compute(dataclasses.replace(frame, memo={})).flat())
    assert first == again
    assert tree(dict(frame.aovs)) == before


@pytest.mark.parametrize("name", NAMES)
def test_its_empty_array_is_of_the_type_of_the_full_one(name, frame):
    annotator = annotators.get(name).attach(known("/Render/Any"))
    try:
        empty = annotator.get_data()
        full = annotator.compute(frame).data
        if full is None:
            assert empty == {}
        else:
            assert (empty.dtype, empty.size) == (full.dtype, 0)
    finally:
        annotator.detach()


@pytest.mark.parametrize("name", [*NAMES, "skeleton_data"])
def test_it_is_documented(name):
    assert annotators.get(name).documentation
