import dataclasses
from typing import Any

import numpy as np
import pytest

from tests.annotators.ray_caster import make_frame
from tests.annotators.scenes import street
from usdsdg import annotators
from usdsdg.errors import AnnotatorError


@pytest.fixture(scope="module")
def frame():
    return make_frame(street(), (64, 48))


def compute(frame, name, **params) -> Any:
    return annotators.get(name, init_params=params).compute(frame)


@pytest.mark.parametrize(
    ("name", "aov", "shape", "dtype"),
    [
        ("rgb", "LdrColor", (48, 64, 4), np.uint8),
        ("LdrColor", "LdrColor", (48, 64, 4), np.uint8),
        ("HdrColor", "HdrColor", (48, 64, 4), np.float16),
        ("distance_to_camera", "distance_to_camera", (48, 64), np.float32),
        ("distance_to_image_plane", "distance_to_image_plane", (48, 64), np.float32),
        ("normals", "normals", (48, 64, 4), np.float32),
        ("motion_vectors", "motion_vectors", (48, 64, 4), np.float32),
    ],
)
def test_images_are_their_aov(frame, name, aov, shape, dtype):
    data = compute(frame, name).data
    assert (data.shape, data.dtype) == (shape, dtype)
    source = frame.aovs[aov]
    np.testing.assert_array_equal(data[..., : source.shape[2]] if source.ndim == 3 else data, source)


@pytest.mark.parametrize(
    "names",
    [
        ("distance_to_image_plane", "DepthLinearized"),
        ("normals", "SmoothNormal"),
        ("rgb", "LdrColor"),
    ],
)
def test_twins_are_one_picture(frame, names):
    one, other = (compute(frame, name).data for name in names)
    assert one.dtype == other.dtype
    np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("name", "aov"), [("PtZDepth", "distance_to_image_plane"), ("PtWorldNormal", "normals"), ("PtWorldPos", "position")]
)
def test_pictures_of_the_path_tracer_are_of_half_precision(frame, name, aov):
    data, source = compute(frame, name).data, frame.aovs[aov]
    assert (data.dtype, data.shape) == (np.float16, (48, 64, 4))
    for channel in range(3):
        expected = source if source.ndim == 2 else source[..., channel]
        # Eleven bits.
        np.testing.assert_allclose(data[..., channel], expected, rtol=2**-11, atol=1e-7)
    assert (data[..., 3] == 1).all()


def test_the_base_color_in_bytes(frame):
    data = compute(frame, "DiffuseAlbedo").data
    assert (data.dtype, data.shape) == (np.uint8, (48, 64, 4))
    assert np.abs(data[..., :3] / 255.0 - np.clip(frame.aovs["albedo"], 0, 1)).max() <= 0.5 / 255 + 1e-6
    assert (data[..., 3] == 255).all()


def test_an_aov_that_was_not_rendered_is_named(frame):
    with pytest.raises(AnnotatorError, match="'normals' was not rendered"):
        compute(dataclasses.replace(frame, aovs={}, memo={}), "normals")


def test_points_are_where_pixel_depth_and_intrinsics_put_them(frame):
    cloud = compute(frame, "pointcloud", includeUnlabelled=True)
    hit = np.isfinite(frame.aovs["distance_to_image_plane"])
    v, u = np.nonzero(hit)
    depth = frame.aovs["distance_to_image_plane"][hit]
    view = frame.camera
    in_camera = np.stack(
        [(u + 0.5 - view.cx) / view.fx * depth, (view.cy - v - 0.5) / view.fy * depth, -depth, np.ones_like(depth)], 1
    )
    # float32 depth of about ten meters
    np.testing.assert_allclose(cloud.data, (in_camera @ view.local_to_world)[:, :3], atol=1e-5)
    np.testing.assert_array_equal(cloud.info["pointRgb"], frame.aovs["LdrColor"][hit])
    np.testing.assert_array_equal(cloud.info["pointNormals"][:, :3], frame.aovs["normals"][hit])


def test_point_ids_are_those_of_the_masks(frame):
    hit = frame.aovs["instance"] >= 0
    for include in (True, False):
        cloud = compute(frame, "pointcloud", includeUnlabelled=include)
        semantic = compute(frame, "semantic_segmentation").data
        instance = compute(frame, "instance_segmentation").data
        kept = hit if include else instance >= 2
        np.testing.assert_array_equal(cloud.info["pointSemantic"], semantic[kept])
        np.testing.assert_array_equal(cloud.info["pointInstance"], instance[kept])
        assert len(cloud.data) == kept.sum()


def test_materials_in_the_types_of_replicator(frame):
    seen = frame.aovs["instance"] >= 0
    for name in ("SpecularAlbedo", "PtReflectionFilter"):
        data = compute(frame, name).data
        assert (data.dtype, data.shape) == (np.float16, (*seen.shape, 4))
        np.testing.assert_array_equal(np.unique(data[seen], axis=0), [np.float16((0.04, 0.5, 1, 1))])
    np.testing.assert_array_equal(compute(frame, "PtDiffuseFilter").data[seen][0], np.float16((0.5, 0.25, 0.125, 1)))
    rough = compute(frame, "Roughness").data
    assert rough.dtype == np.uint8
    np.testing.assert_array_equal(np.unique(rough[seen], axis=0), [[77, 77, 77, 255]])  # 0.3 * 255
    np.testing.assert_array_equal(np.unique(rough[~seen], axis=0), [[0, 0, 0, 255]])
    bumped = compute(frame, "BumpNormal").data
    np.testing.assert_array_equal(bumped[..., :3], frame.aovs["bump_normals"])
    glow = compute(frame, "PtSelfIllumination").data
    np.testing.assert_array_equal(glow[seen][0], np.float16((0, 20, 65504, 1)))


def test_light_of_surfaces_and_where_there_are_any(frame):
    data = compute(frame, "EmissionAndForegroundMask").data
    assert (data.dtype, data.shape) == (np.float16, (48, 64, 4))
    np.testing.assert_array_equal(data[..., :3], compute(frame, "PtSelfIllumination").data[..., :3])
    np.testing.assert_array_equal(data[..., 3], frame.aovs["instance"] >= 0)
    assert len(np.unique(data[..., 3])) == 2


def test_motion_has_three_names(frame):
    moved = np.random.default_rng(0).normal(size=(48, 64, 2)).astype(np.float32)
    frame = dataclasses.replace(frame, aovs={**frame.aovs, "motion_vectors": moved}, memo={})
    for name in ("motion_vectors", "MotionVectors", "Motion2d"):
        data = compute(frame, name).data
        assert data.dtype == np.float32
        np.testing.assert_array_equal(data[..., :2], moved)
        assert not data[..., 2:].any()


def test_the_background_is_what_is_seen_beside_things(frame):
    seen = frame.aovs["instance"] >= 0
    data = compute(frame, "PtBackground").data
    assert data.dtype == np.float16
    assert not data[seen].any()
    np.testing.assert_array_equal(data[~seen], frame.aovs["HdrColor"][~seen])
    assert data[~seen].any()
