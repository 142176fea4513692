"""The model of a stereo pair against what geometry says of planes. Focal length times baseline is 50 m px."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from usdsdg.annotators.kinds.depth import stereo
from usdsdg.annotators.kinds.depth.stereo import DepthSensor
from usdsdg.annotators.pixels.launch import on_host

WIDTH = 500
PAIR = DepthSensor(
    baseline_mm=50,
    focal_length_pixel=1000,
    sensor_size_pixel=WIDTH,
    max_disparity_pixel=1000,
    confidence_threshold=1,
    noise_mean=0,
    noise_sigma=0.5,
    noise_downscale_factor_pixel=1,
    outlier_removal_enabled=False,
    min_distance=0,
    max_distance=np.inf,
)


def wall(depth: float, height: int = 4) -> np.ndarray:
    return np.full((height, WIDTH), depth, np.float32)


def measure(sensor: DepthSensor, depth: np.ndarray, confident: np.ndarray | None = None, seed: int = 0):
    everywhere = np.ones(depth.shape, bool) if confident is None else confident
    return stereo.measure(sensor, depth, everywhere, np.random.default_rng(seed))


# Geometry


def test_disparity_is_focal_length_times_baseline_over_depth_in_pixels_of_the_picture():
    assert PAIR.disparity_times_depth(WIDTH) == pytest.approx(50)
    assert PAIR.disparity_times_depth(2 * WIDTH) == pytest.approx(100)
    assert replace(PAIR, sensor_size_pixel=2 * WIDTH).disparity_times_depth(WIDTH) == pytest.approx(25)
    assert replace(PAIR, baseline_mm=-50).disparity_times_depth(WIDTH) == pytest.approx(50)


@pytest.mark.parametrize(("baseline", "missing"), [(50, slice(WIDTH - 25, None)), (-50, slice(0, 25))])
def test_a_wall_is_measured_exactly_where_both_see_it(baseline, missing):
    found = measure(replace(PAIR, baseline_mm=baseline), wall(2))
    expected = wall(2)
    expected[:, missing] = 0
    np.testing.assert_allclose(found.distance, expected, rtol=1e-6)
    np.testing.assert_array_equal(found.measured, expected > 0)


@given(near=st.floats(0.5, 3), gap=st.floats(0.05, 5), baseline=st.sampled_from([50, -50, 20]))
def test_the_shadow_beside_an_edge_is_as_wide_as_the_disparities_differ(near, gap, baseline):
    depth = wall(near + gap)
    depth[:, 200:300] = near
    sensor = replace(PAIR, baseline_mm=baseline)
    found = measure(sensor, depth)
    strength = sensor.disparity_times_depth(WIDTH)
    first, second = strength / depth[0, 200].astype(float), strength / depth[0, 0].astype(float)
    right = baseline > 0
    edge = 300 - first if right else 200 + first
    columns = np.arange(WIDTH) + 0.5
    inside = (columns > edge) & (columns < edge + first - second) if right else (
        (columns < edge) & (columns > edge - first + second)
    )  # fmt: skip
    here = (columns > 150) & (columns < 400)
    # A pixel moves by whole columns, so each end of the shadow is off by less than one.
    assert abs((~found.measured[0] & here).sum() - (first - second)) < 1.001
    assert (found.measured[0] & inside).sum() <= 2
    object_columns = np.isclose(found.distance[0], near, rtol=1e-5)
    assert object_columns.sum() == 100


def test_of_pixels_that_meet_the_nearest_is_seen():
    depth = wall(10)
    depth[:, 200:210] = 1
    found = measure(PAIR, depth)
    # The near strip moves 50 columns to the left, the wall 5.
    np.testing.assert_allclose(found.distance[:, 150:160], 1)
    np.testing.assert_array_equal(found.source[1, 150:160], WIDTH + np.arange(200, 210))
    np.testing.assert_allclose(found.distance[:, 140:150], 10)
    assert not found.measured[:, 195:205].any()


# Noise


@given(step=st.sampled_from([0.25, 0.5, 1.0, -1.0]), seed=st.integers(0, 100))
def test_distances_come_in_steps_that_grow_with_the_square_of_the_depth(step, seed):
    depth = np.random.default_rng(seed).uniform(1, 8, (4, WIDTH)).astype(np.float32)
    found = measure(replace(PAIR, noise_mean=step, noise_sigma=0), depth)
    levels = np.unique(found.distance[found.measured].astype(np.float64))
    counts = 50 / levels / abs(step)
    np.testing.assert_allclose(counts, np.rint(counts), atol=1e-4)
    gaps, products = np.diff(levels), levels[1:] * levels[:-1]
    neighbors = np.isclose(np.diff(counts), -1, atol=1e-3)
    assert neighbors.sum() > 5
    np.testing.assert_allclose(gaps[neighbors], (products * abs(step) / 50)[neighbors], rtol=1e-3)
    exact = depth.ravel()[found.source[found.measured]]
    # Half a step of disparity, to first and second order.
    half = abs(step) / 2
    assert (np.abs(50 / found.distance[found.measured] - 50 / exact) <= half * 1.0001).all()


@pytest.mark.parametrize("sigma", [0.1, 0.5, -0.5])
@pytest.mark.parametrize("depth", [1.0, 2.0, 5.0])
def test_errors_on_a_wall_are_normal_and_grow_with_the_square_of_the_depth(sigma, depth):
    found = measure(replace(PAIR, noise_mean=1e-6, noise_sigma=sigma), wall(depth, 400))
    read = found.distance[found.measured].astype(np.float64)
    assert len(read) > 150_000
    disparity = 50 / read - 50 / depth
    # Of 150,000 draws: five times the standard errors of mean and deviation.
    assert abs(disparity.mean()) < 5 * abs(sigma) / 150_000**0.5
    assert disparity.std() == pytest.approx(abs(sigma), rel=5 / (2 * 150_000) ** 0.5)
    # First order: the third moment of a normal distribution adds less than this at these depths.
    assert read.std() == pytest.approx(depth**2 / 50 * abs(sigma), rel=0.02)
    assert found.measured[:, : WIDTH - 51].all()


@pytest.mark.parametrize("side", [1.0, 1.5, 3.0])
def test_coarse_noise_is_shared_by_blocks(side):
    sensor = replace(PAIR, noise_mean=1e-6, noise_downscale_factor_pixel=side)
    disparity = measure(sensor, np.full((30, 31), 0.155, np.float32)).disparity
    block = (np.arange(30) // side)[:, None] * 1000 + np.arange(31) // side
    values = [np.unique(disparity[block == one]) for one in np.unique(block)]
    assert all(len(each) == 1 for each in values)
    assert len(np.unique(np.concatenate(values))) == len(values)


def test_without_steps_there_is_no_noise():
    np.testing.assert_allclose(measure(replace(PAIR, noise_sigma=9), wall(2)).distance[:, :400], 2)


def test_noise_repeats_with_its_generator():
    noisy = replace(PAIR, noise_mean=0.25)
    one, again, other = (measure(noisy, wall(2), seed=seed).distance for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, again)
    assert (one != other).any()


# What is not measured


def test_nothing_hit_is_not_measured_whatever_the_noise():
    depth = wall(np.inf)
    depth[:, :100] = -1  # behind the plane of a very wide lens
    found = measure(replace(PAIR, noise_mean=0.25, noise_sigma=5), depth)
    assert not found.measured.any()
    assert not found.distance.any()


def test_ranges_cut_what_is_measured():
    depth = wall(1)
    depth[:] = np.linspace(0.5, 10, WIDTH)
    found = measure(replace(PAIR, min_distance=2, max_distance=5), depth)
    read = found.distance[found.measured]
    assert read.size > 100
    assert read.min() >= 2
    assert read.max() <= 5
    # 40 pixels of a sensor of 500, whatever the picture's width.
    for width in (WIDTH, 2 * WIDTH):
        wide = np.tile(np.linspace(0.5, 10, width, dtype=np.float32), (2, 1))
        nearest = measure(replace(PAIR, max_disparity_pixel=40), wide).distance
        assert nearest[nearest > 0].min() == pytest.approx(50 / 40, abs=0.03)
        assert nearest[nearest > 0].min() >= 50 / 40 * 0.99999


def test_what_cannot_be_measured_still_hides_what_is_behind_it():
    depth = wall(10)
    depth[:, 200:300] = 1
    hidden = measure(replace(PAIR, min_distance=2), depth).measured
    assert not hidden[:, 150:250].any()
    smooth = np.ones(depth.shape, bool)
    smooth[:, 200:300] = False
    np.testing.assert_array_equal(measure(PAIR, depth, smooth).measured, hidden)


def without_outliers(source, read):
    """As the sensor mends what it has read: `read` is the distance of the camera's pixels."""
    return on_host(stereo._read(source.astype(np.int32), read.reshape(source.shape), mends=True)[0])


def test_lone_pixels_match_their_neighbors():
    source = np.arange(35).reshape(5, 7)
    read = np.arange(35.0)
    source[1, 3] = source[3, 0] = source[4, 6] = -1
    filled = without_outliers(source, read)
    assert filled[1, 3] == 11  # the farther of 9 and 11
    assert (filled[3, 0], filled[4, 6]) == (-1, -1)  # at the border there is one neighbor only
    assert (filled >= 0).sum() == 33
    lone = np.full((5, 7), -1)
    lone[2, 2] = 16
    assert (without_outliers(lone, read) == -1).all()
    lone[3, 3] = 24
    np.testing.assert_array_equal(without_outliers(lone, read), lone)


def test_outlier_removal_closes_the_cracks_of_a_slanted_surface():
    slanted = np.tile(
        np.linspace(2, 1, WIDTH, dtype=np.float32), (4, 1)
    )  # disparity falls to the left: it is stretched
    columns = slice(60, 380)
    with_cracks = measure(PAIR, slanted[:, ::-1]).measured[:, columns]
    closed = measure(replace(PAIR, outlier_removal_enabled=True), slanted[:, ::-1])
    assert not with_cracks.all()
    assert closed.measured[:, columns].all()
    assert (np.diff(closed.distance[0, columns]) >= 0).all()


# Confidence


def test_smooth_surfaces_are_measured_at_a_threshold_of_one_only():
    flat = np.full((6, 8), 100, np.float32)
    assert stereo.is_confident(PAIR, flat).all()
    assert not stereo.is_confident(replace(PAIR, confidence_threshold=0.999), flat).any()


@given(st.lists(st.floats(0, 1), min_size=2, max_size=4), st.integers(0, 9))
def test_lower_thresholds_reject_more(thresholds, seed):
    gray = np.cumsum(np.random.default_rng(seed).uniform(0, 0.2, (12, 12)), axis=1).astype(np.float32)
    kept = [stereo.is_confident(replace(PAIR, confidence_threshold=each), gray) for each in sorted(thresholds)]
    for stricter, laxer in itertools.pairwise(kept):
        assert not (stricter & ~laxer).any()


def test_texture_is_the_gradient_up_to_one_gray_level_between_neighbors():
    ramp = np.tile(np.arange(8, dtype=np.float32), (6, 1)) / 20  # Sobel adds up eight such differences
    inner = (slice(1, -1), slice(1, -1))
    np.testing.assert_allclose(stereo.texture(ramp)[inner], 0.4, rtol=1e-5)
    np.testing.assert_allclose(stereo.texture(ramp.T * 100), 1)
    sensor = replace(PAIR, confidence_threshold=0.61)
    assert stereo.is_confident(sensor, ramp)[inner].all()
    assert not stereo.is_confident(replace(PAIR, confidence_threshold=0.59), ramp)[inner].any()
    np.testing.assert_allclose(stereo.confidence(sensor, ramp)[inner], 0.4 * 0.61, rtol=1e-5)


def test_luminance_is_that_of_rec_709():
    color = np.array([[[255, 0, 0, 9], [0, 255, 0, 9], [0, 0, 255, 9], [255, 255, 255, 0]]], np.uint8)
    np.testing.assert_allclose(stereo.luminance(color), [[54.213, 182.376, 18.411, 255]], rtol=1e-5)
