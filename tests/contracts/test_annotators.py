"""Contract of every registered annotator."""

import dataclasses

import numpy as np
import pytest
import warp as wp
from pxr import Sdf

from tests.annotators.ray_caster import CAMERA, known, make_frame, new_stage
from tests.annotators.scenes import add_camera, street
from usdsdg import annotators
from usdsdg.annotators.delivery import delivered
from usdsdg.session import render_products, stage_context
from usdsdg.stage.geometry.pixel_masks import PixelMasks

NAMES = annotators.get_registered_annotators()
IMAGE = {"LdrColor", "HdrColor"}
# Parameters without which an annotator returns nothing.
PARAMS = {"Attribute": {"prims": [CAMERA], "attribute": "focalLength"}}
# The system time differs at every call.
REPEATING = [name for name in NAMES if name != "IsaacReadSystemTime"]
# Annotators whose pixels stay where the AOVs are.
ON_DEVICE = (
    "rgb", "normals", "distance_to_camera", "distance_to_image_plane", "motion_vectors", "semantic_segmentation",
    "instance_segmentation", "instance_id_segmentation", "pointcloud", "object_coordinates", "PtWorldNormal",
    "PtWorldPos", "Roughness", "DirectDiffuse", "PtBackground", "LdrColorIsaacConvertRGBAToRGB",
    "DistanceToImagePlaneSDIsaacConvertDepthToPointCloud", "shaded_semantic_segmentation", "PtMultiMatte0",
    "PtVolumes", "DepthSensorDistance", "DepthSensorPointCloudPosition", "DepthSensorPointCloudColor",
    "DepthSensorImager",
)  # fmt: skip


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
def test_an_annotator_uses_only_what_it_declares(name, frame):
    annotator = get(name)
    given = set(annotator.aovs) | (IMAGE if annotator.spec.needs_path_tracing else set())
    masks = frame.amodal_masks if annotator.spec.needs_amodal_masks else PixelMasks.nothing(frame.shape)
    prims = frame.labeled_prims
    if not annotator.spec.needs_poses:
        prims = dataclasses.replace(prims, bounds=prims.bounds[:0], local_to_world=prims.local_to_world[:0])
    aovs = {k: v for k, v in frame.aovs.items() if k in given}
    bare = dataclasses.replace(frame, aovs=aovs, amodal_masks=masks, labeled_prims=prims, memo={})
    assert tree(annotator.compute(bare).flat()) == tree(get(name).compute(frame).flat())


@pytest.mark.parametrize("name", REPEATING)
def test_an_annotator_does_not_change_the_frame_and_repeats_its_result(name, frame):
    before = tree(dict(frame.aovs))
    first = tree(get(name).compute(dataclasses.replace(frame, memo={})).flat())
    again = tree(get(name).compute(dataclasses.replace(frame, memo={})).flat())
    assert first == again
    assert tree(dict(frame.aovs)) == before


def warp_image(array: np.ndarray) -> wp.array:
    """An AOV as a renderer leaves it on a GPU: a Warp array of numbers or vectors."""
    vectors = {"f2": wp.vec4h, "u1": wp.vec4ub, 2: wp.vec2, 3: wp.vec3}
    if array.ndim == 2:
        return wp.array(array, device="cpu")
    return wp.array(array, dtype=vectors.get(array.dtype.str[1:]) or vectors[array.shape[2]], device="cpu")


@pytest.mark.parametrize("name", REPEATING)
def test_an_annotator_gives_the_same_of_aovs_on_a_device(name, frame):
    on_device = dataclasses.replace(frame, aovs={k: warp_image(v) for k, v in frame.aovs.items()}, memo={})
    found = get(name).compute(on_device)
    assert tree(delivered(found, None, copy=False).flat()) == tree(get(name).compute(frame).flat())
    if name in ON_DEVICE:
        assert isinstance(found.data, wp.array)
        numbers = delivered(found, "cuda:7", copy=False).data
        assert (numbers.ptr, numbers.shape) == (found.data.ptr, found.data.numpy().shape)


def test_a_frame_that_waits_holds_its_aovs_on_the_host(frame):
    on_device = dataclasses.replace(frame, aovs={k: warp_image(v) for k, v in frame.aovs.items()}, memo={})
    assert tree(dict(on_device.hosted().aovs)) == tree(dict(frame.aovs))
    assert on_device.hosted() is on_device.hosted()
    assert frame.hosted() is frame


@pytest.mark.parametrize("name", NAMES)
def test_data_before_the_first_frame_are_empty_and_of_the_same_form(name, frame):
    annotator = get(name).attach(known("/Render/Any"))
    try:
        empty, flat = annotator.get_data(), annotator.get_data(use_legacy_structure=False)
        annotator.compute(frame)
        assert form(empty) == form(annotator.get_data())
        assert form(flat) == form(annotator.get_data(use_legacy_structure=False))
        assert len(flat.get("data", ())) == 0
    finally:
        annotator.detach()


def form(value, depth=2):
    """Return the type of a value, dtypes of arrays, and the forms of the entries of a dictionary and of its info."""
    if isinstance(value, dict) and depth and all(isinstance(key, str) and key.isalnum() for key in value):
        return {key: form(item, depth - 1 if key == "info" else 0) for key, item in value.items()}
    return value.dtype if isinstance(value, np.ndarray) else type(value)


@pytest.mark.parametrize("name", NAMES)
def test_every_annotator_is_documented(name):
    assert get(name).documentation
