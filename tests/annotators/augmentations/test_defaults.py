"""Replicator's default augmentations against slow or independent versions of themselves."""

import colorsys
import dataclasses
import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image

from tests.annotators.ray_caster import make_frame
from tests.annotators.scenes import street
from usdsdg import annotators, augmentations_default
from usdsdg.annotators.augmentations import colors, filters, geometry, images, noise
from usdsdg.annotators.augmentations.defaults import DEFAULT_AUGMENTATIONS
from usdsdg.errors import AugmentationError
from usdsdg.graph.sampling import set_global_seed

pictures = arrays(np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 9), st.sampled_from([3, 4])))


def picture(height=20, width=30, channels=4, seed=0):
    return np.random.default_rng(seed).integers(0, 256, (height, width, channels), np.uint8)


def smooth(height=32, width=40):
    """A picture without sharp edges, so that half a pixel changes little."""
    y, x = np.mgrid[:height, :width]
    channels = [128 + 60 * np.sin(x / 9) + 60 * np.cos(y / 7), 3 * x + y, 255 - 2 * y]
    return np.clip(np.dstack([*channels, np.full((height, width), 255)]), 0, 255).astype(np.uint8)


def apart(a, b):
    return np.abs(a.astype(int) - b.astype(int)).max()


# Each pixel by itself


def test_rgba_to_rgb():
    image = picture()
    np.testing.assert_array_equal(augmentations_default.rgba_to_rgb(image), image[..., :3])


@given(image=pictures, cutoff=st.floats(0, 1), gain=st.floats(0.1, 20))
def test_adjust_sigmoid(image, cutoff, gain):
    out = augmentations_default.aug_adjust_sigmoid(image, cutoff=cutoff, gain=gain)
    expected = 255 / (1 + np.exp(gain * (cutoff - image[..., :3] / 255)))
    assert apart(out[..., :3], expected.astype(np.uint8)) <= 1
    np.testing.assert_array_equal(out[..., 3:], image[..., 3:])


@given(image=pictures, factor=st.sampled_from([0.0, 0.5, 1.0, 2.0, 100.0]))
def test_brightness(image, factor):
    out = augmentations_default.aug_brightness(image, brightness_factor=factor)
    np.testing.assert_array_equal(out[..., :3], np.minimum(image[..., :3] * factor, 255).astype(np.uint8))
    np.testing.assert_array_equal(out[..., 3:], image[..., 3:])


def test_contrast():
    image = picture()
    mean = np.mean([int(0.2989 * r + 0.587 * g + 0.114 * b) for r, g, b in image[..., :3].reshape(-1, 3)])
    for factor in (0.0, 0.5, 1.0, 2.0):
        out = colors.contrast(image, contrastFactor=factor)
        expected = np.clip(image[..., :3] * factor + (1 - factor) * mean, 0, 255).astype(np.uint8)
        assert apart(out[..., :3], expected) <= 1
    assert np.ptp(colors.contrast(image, contrastFactor=0.0)[..., :3]) == 0
    np.testing.assert_array_equal(colors.contrast(image, contrastFactor=1.0), image)


@given(image=pictures)
def test_rgb_to_hsv_agrees_with_colorsys(image):
    out = augmentations_default.aug_rgb_to_hsv(image)
    for rgb, (h, s, v) in zip(image[..., :3].reshape(-1, 3) / 255, out[..., :3].reshape(-1, 3).astype(int)):
        hue, saturation, value = colorsys.rgb_to_hsv(*rgb)
        assert v == round(value * 255)
        assert abs(s - saturation * 255) <= 1
        # A sixth of a turn is 43 here and 42.7 in truth; grays have no hue.
        assert s == 0 or abs((h - hue * 256 + 128) % 256 - 128) <= 2.5
    np.testing.assert_array_equal(out[..., 3:], image[..., 3:])


# Hue is cut off to whole numbers, and those of purples wrap at 256 instead of six sectors of 43: three of 43 parts of
# the largest spread, and whole numbers in three products.
HUE_STEP = 255 * 3 / 43 + 3


@given(image=pictures)
def test_hsv_to_rgb_undoes_rgb_to_hsv(image):
    again = augmentations_default.aug_hsv_to_rgb(augmentations_default.aug_rgb_to_hsv(image))
    assert apart(again, image) <= HUE_STEP


@pytest.mark.parametrize(
    ("rgb", "hsv"),
    [((0, 0, 0), (0, 0, 0)), ((90, 90, 90), (0, 0, 90)), ((255, 0, 0), (0, 255, 255)), ((0, 200, 0), (85, 255, 200)),
     ((0, 0, 255), (171, 255, 255)), ((255, 0, 10), (254, 255, 255))],
)  # fmt: skip
def test_hsv_of_known_colors(rgb, hsv):
    image = np.array([[rgb]], np.uint8)
    assert tuple(augmentations_default.aug_rgb_to_hsv(image)[0, 0]) == hsv
    assert apart(augmentations_default.aug_hsv_to_rgb(np.array([[hsv]], np.uint8)), image) <= HUE_STEP


def test_colorize_depth():
    depth = np.array([[0.01, 0.1, 1.0, 10.0, 100.0, 1e6, np.inf, -np.inf, np.nan]], np.float32)
    out = augmentations_default.colorize_depth(depth)
    assert out.shape == (1, 9, 4)
    assert apart(out[0, :, 0], np.array([255, 255, 170, 85, 0, 0, 0, 0, 0])) <= 1
    assert (out[..., 3] == 255).all()
    np.testing.assert_array_equal(out[..., 0], out[..., 2])
    narrow = augmentations_default.colorize_depth(depth, near=1.0, far=10.0)
    assert narrow[0, :5, 1].tolist() == [255, 255, 255, 0, 0]


def test_colorize_normals():
    normals = np.array([[[1, 0, 0, 1], [0, -1, 0, 1], [0, 0, 0, 1]]], np.float32)
    out = augmentations_default.colorize_normals(normals)
    assert out.tolist() == [[[255, 127, 127, 255], [127, 0, 127, 255], [0, 0, 0, 255]]]


# Noise


def test_speckle_noise_is_in_proportion_to_the_value():
    image = np.zeros((300, 300, 4), np.uint8)
    image[..., 0], image[..., 1], image[..., 3] = 50, 100, 77
    noisy = augmentations_default.aug_speckle_noise(image, sigma=0.1, seed=3).astype(float)
    # 90,000 samples know the deviation to 0.24 %; whole numbers add 0.3 and take 0.5 off the mean.
    for channel, value in ((0, 50), (1, 100)):
        assert noisy[..., channel].std() == pytest.approx(np.hypot(0.1 * value, 0.29), rel=0.015)
        assert noisy[..., channel].mean() == pytest.approx(value - 0.5, abs=4 * 0.1 * value / 300)
    assert not noisy[..., 2].any()
    assert (noisy[..., 3] == 77).all()
    assert abs(np.corrcoef(noisy[..., 0].ravel(), noisy[..., 1].ravel())[0, 1]) < 4 / 300


def test_shot_noise_is_that_of_counted_photons():
    image = np.full((300, 300, 3), 128, np.uint8)
    noisy = augmentations_default.aug_shot_noise(image, sigma=400.0, seed=3) / 255.0
    assert noisy.std() == pytest.approx(np.sqrt(128 / 255 / 400), rel=0.01)
    assert noisy.mean() == pytest.approx(127.5 / 255, abs=0.001)
    with pytest.raises(ValueError, match="sigma is 0"):
        augmentations_default.aug_shot_noise(image, sigma=0)


@settings(max_examples=30)
@given(delta=st.integers(1, 4), seed=st.integers(0, 100))
def test_glass_blur_takes_colors_from_nearby(delta, seed):
    y, x = np.mgrid[:20, :30]
    image = np.dstack([y, x, y * 0, y]).astype(np.uint8)
    out = augmentations_default.aug_glass_blur(image, delta=delta, seed=seed).astype(int)
    assert np.abs(out[..., 0] - y).max() <= delta
    assert np.abs(out[..., 1] - x).max() <= delta
    np.testing.assert_array_equal(out[..., 3], y)
    assert (out[..., 1] != x).any()


def test_glass_blur_needs_room():
    with pytest.raises(ValueError, match="delta is 0"):
        noise.glass_blur(picture(), delta=0)


@pytest.mark.parametrize("function", ["aug_speckle_noise", "aug_shot_noise", "aug_glass_blur"])
def test_noise_repeats_and_follows_its_seed(function):
    make = getattr(augmentations_default, function)
    np.testing.assert_array_equal(make(picture(), seed=4), make(picture(), seed=4))
    assert (make(picture(), seed=4) != make(picture(), seed=5)).any()


# Neighbors


def correlated(image, weights):
    """Slow: each output pixel as a sum over the window, with the border continued."""
    half = len(weights) // 2
    padded = np.pad(image[..., :3].astype(float), ((half, half), (half, half), (0, 0)), mode="edge")
    out = np.zeros((*image.shape[:2], 3))
    for i in range(len(weights)):
        for j in range(len(weights)):
            out += weights[i, j] * padded[i : i + image.shape[0], j : j + image.shape[1]]
    return np.clip(out, 0, 255)


@pytest.mark.parametrize("flat", [False, True])
def test_conv2d(flat):
    image, weights = picture(), np.random.default_rng(1).normal(0, 0.3, (5, 5))
    out = filters.conv2d(image, kernel=weights.ravel() if flat else weights, alpha=0.7)
    expected = 0.7 * correlated(image, weights) + 0.3 * image[..., :3]
    assert apart(out[..., :3], expected) <= 1
    np.testing.assert_array_equal(out[..., 3], image[..., 3])


def test_conv2d_keeps_a_constant_picture_and_refuses_odd_kernels():
    gray = np.full((9, 9, 3), 201, np.uint8)
    np.testing.assert_array_equal(filters.conv2d(gray, kernel=np.full((3, 3), 1 / 9)), gray)
    with pytest.raises(ValueError, match="not square"):
        filters.conv2d(gray, kernel=[1.0, 2.0])
    with pytest.raises(ValueError, match="has no middle"):
        filters.conv2d(gray, kernel=np.ones((2, 2)))


@pytest.mark.parametrize(
    ("angle", "strength", "place"),
    # The part of the line ahead of the motion brings in what lies there.
    [(0, 1.0, (10, 12)), (90, 1.0, (8, 10)), (270, 1.0, (12, 10)), (180, 1.0, (10, 8)), (0, -1.0, (10, 8))],
)
def test_motion_blur_leans_to_the_side_of_the_motion(angle, strength, place):
    image = np.zeros((21, 21, 3), np.uint8)
    image[10, 10] = 250
    out = filters.motion_blur(image, motionAngle=angle, strength=strength, kernelSize=5, alpha=1.0)[..., 0]
    assert np.unravel_index(out.argmax(), out.shape) == place
    assert abs(int(out.sum()) - 250) <= 5
    mirrored = (20 - place[0], 20 - place[1])
    assert out[mirrored] == 0


def test_motion_blur_without_strength_is_a_mean_along_the_line():
    image = picture(24, 24, 3)
    out = filters.motion_blur(image, motionAngle=0, strength=0.0, kernelSize=5, alpha=1.0)
    weights = np.zeros((5, 5))
    weights[2] = 0.2
    assert apart(out, correlated(image, weights)) <= 1
    turned = filters.motion_blur(image, motionAngle=90, strength=0.0, kernelSize=5, alpha=1.0)
    assert apart(turned, correlated(image, weights.T)) <= 1
    half = filters.motion_blur(image, motionAngle=0, strength=0.0, kernelSize=5, alpha=0.5)
    assert apart(half, (out.astype(float) + image) / 2) <= 1
    with pytest.raises(ValueError, match="kernelSize is 1"):
        filters.motion_blur(image, kernelSize=1)


@given(image=pictures, size=st.integers(1, 12))
def test_pixellate(image, size):
    out = filters.pixellate(image, kernelSize=size)
    for top in range(0, image.shape[0], size):
        for left in range(0, image.shape[1], size):
            block = slice(top, top + size), slice(left, left + size), slice(0, 3)
            expected = image[block].reshape(-1, 3).mean(axis=0)
            assert np.abs(out[block] - np.floor(expected + 1e-9)).max() <= 1
            assert np.ptp(out[block].reshape(-1, 3), axis=0).max() == 0
    with pytest.raises(ValueError, match="kernelSize is 0"):
        filters.pixellate(image, kernelSize=0)


def test_sobel():
    image = picture(12, 15)
    gray = image[..., :3].mean(axis=-1)
    out = augmentations_default.sobel_edges(image)
    for i in range(12):
        for j in range(15):
            expected = 0
            if 0 < i < 11 and 0 < j < 14:
                window = gray[i - 1 : i + 2, j - 1 : j + 2]
                gx = (window * [[-1, 0, 1], [-2, 0, 2], [-1, 0, 1]]).sum()
                gy = (window * [[-1, -2, -1], [0, 0, 0], [1, 2, 1]]).sum()
                expected = min(np.hypot(gx, gy) / 4, 255)
            assert abs(out[i, j, 0] - expected) <= 1
    assert (out[..., 3] == 255).all()
    assert augmentations_default.sobel_edges(picture(2, 2)).shape == (2, 2, 4)


def test_canny_finds_the_outline_of_a_square_and_of_a_circle():
    image = np.zeros((60, 60, 3), np.uint8)
    image[20:40, 15:45] = 200
    edges = filters.canny(image)
    assert edges.dtype == np.uint8
    assert set(np.unique(edges)) == {0, 255}
    y, x = np.nonzero(edges)
    outline = np.minimum.reduce([abs(y - 19.5), abs(y - 39.5), abs(x - 14.5), abs(x - 44.5)])
    assert outline.max() <= 1.5, "no edge away from the outline"
    assert edges[30].sum() == 2 * 255, "one pixel thick"
    assert edges[:, 30].sum() == 2 * 255

    y, x = np.mgrid[:80, :80]
    disc = np.where(np.hypot(y - 40, x - 40) < 25, 220, 10).astype(np.uint8)
    y, x = np.nonzero(filters.canny(np.dstack([disc] * 3)))
    assert np.abs(np.hypot(y - 40, x - 40) - 25).max() < 2
    assert len(set(np.round(np.degrees(np.arctan2(y - 40, x - 40)) / 6))) >= 60, "closed"


def test_canny_keeps_weak_edges_only_beside_strong_ones():
    image = np.zeros((40, 60), np.uint8)
    image[:, 10:] = np.linspace(2, 60, 40).astype(np.uint8)[:, None]  # one edge that becomes stronger downwards
    image[:, 40:] = image[:, 39:40] + 2  # one that is weak everywhere
    picture = np.dstack([image] * 3)
    weak = filters.canny(picture, thresholdLow=10, thresholdHigh=10)
    both = filters.canny(picture, thresholdLow=10, thresholdHigh=300)
    assert weak[5:35, 38:42].any()
    assert not both[5:35, 38:42].any()
    assert both[8:35, 8:12].any(axis=1).all(), "the weak part of the strong edge stays"
    assert not filters.canny(picture, thresholdLow=5000, thresholdHigh=6000).any()
    assert filters.canny(np.zeros((2, 2, 3), np.uint8)).shape == (2, 2)


# Moved pixels


def resampled(image, xform, outside):
    """Slow: every output pixel looks up where it comes from, linearly."""
    back = np.linalg.inv(xform)
    height, width = image.shape[:2]
    out = np.zeros(image.shape)
    for row in range(height):
        for column in range(width):
            x, y, _ = back @ (column, row, 1)
            if outside == "nearest":
                x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
            if not (-1e-6 <= x <= width - 1 + 1e-6 and -1e-6 <= y <= height - 1 + 1e-6):
                continue
            x0, y0 = min(int(x + 1e-9), width - 2), min(int(y + 1e-9), height - 2)
            tx, ty = x - x0, y - y0
            corners = image[y0 : y0 + 2, x0 : x0 + 2].astype(float)
            out[row, column] = (corners[0, 0] * (1 - tx) + corners[0, 1] * tx) * (1 - ty) + (
                corners[1, 0] * (1 - tx) + corners[1, 1] * tx
            ) * ty
    return out


@pytest.mark.parametrize("factor", [0.3, 0.5, 1.0])
@pytest.mark.parametrize("offset", [(0, 0), (1, 1), (-1, 0.5)])
def test_crop_resize(factor, offset):
    image = picture(20, 30)
    out = geometry.crop_resize(image, cropFactor=factor, offsetFactor=offset)
    assert apart(out.data, resampled(image, out.xform, "nearest")) <= 1
    # The corners of the result are those of the part that was cut out.
    rows, columns = int(20 * factor), int(30 * factor)
    first = np.linalg.inv(out.xform) @ (0, 0, 1)
    last = np.linalg.inv(out.xform) @ (29, 19, 1)
    np.testing.assert_allclose(last - first, (columns - 1, rows - 1, 0), atol=1e-9)
    assert (first[:2] >= -1e-9).all()
    assert last[0] <= 29.001
    assert last[1] <= 19.001


def test_crop_resize_moves_contents_to_the_top_and_right():
    image = np.zeros((20, 20, 3), np.uint8)
    image[15:, :5] = 255  # bottom left
    assert geometry.crop_resize(image, cropFactor=0.25, offsetFactor=(1.0, 1.0)).data.min() == 255
    np.testing.assert_array_equal(geometry.crop_resize(image, cropFactor=1.0).data, image)


@pytest.mark.parametrize(
    ("options", "message"),
    [({"cropFactor": 0.0}, "cropFactor is 0.0"), ({"cropFactor": 1.5}, "cropFactor is 1.5"),
     ({"cropFactor": 0.5, "offsetFactor": (2, 0)}, "offsetFactor is"), ({"cropFactor": 0.01}, "leaves nothing")],
)  # fmt: skip
def test_crop_resize_refuses_what_is_no_part(options, message):
    with pytest.raises(ValueError, match=message):
        geometry.crop_resize(picture(), **options)


@pytest.mark.parametrize("rotation", [0, 30, 90, -45, 200])
def test_rotate(rotation):
    image = smooth()
    out = geometry.rotate(image, rotation=rotation)
    expected = resampled(image, out.xform, "constant")
    # The border, of which a part comes from outside, aside.
    inside = (expected[..., 3] == 255) & (out.data[..., 3] == 255)
    assert inside.mean() > 0.5
    assert apart(out.data[inside], expected[inside]) <= 1
    outside = np.linalg.inv(out.xform) @ np.array([[0], [0], [1.0]])
    if not (-1 < outside[0, 0] < 40 and -1 < outside[1, 0] < 32):
        assert not out.data[0, 0].any()


def test_rotate_turns_counter_clockwise_about_the_middle():
    image = picture(21, 21)
    for rotation, turns in ((0, 0), (90, 1), (180, 2), (-90, 3)):
        out = geometry.rotate(image, rotation=rotation)
        np.testing.assert_array_equal(out.data, np.rot90(image, turns))
        np.testing.assert_allclose(out.xform @ (10, 10, 1), (10, 10, 1), atol=1e-9)
    # Replicator's documented example for 640 x 480.
    np.testing.assert_allclose(
        geometry.rotate(np.zeros((480, 640, 3), np.uint8), rotation=90).xform,
        [[0, 1, 80], [-1, 0, 559], [0, 0, 1]],
        atol=1e-9,
    )


# Other pictures


@pytest.fixture
def folder(tmp_path):
    for name, value in (("a.png", 0), ("b.jpg", 100), ("c.bmp", 200)):
        Image.new("RGB", (7, 5), (value, value, value)).save(tmp_path / name)
    (tmp_path / "notes.txt").write_text("no picture")
    return tmp_path


def test_image_blend_mixes_and_draws_every_picture(folder):
    image = picture(12, 10)
    seen = set()
    for seed in range(40):
        out = images.image_blend(image, folderpath=str(folder), blendFactor=0.25, seed=seed)
        fits = [v for v in (0, 100, 200) if apart(out[..., :3], 0.75 * image[..., :3] + 0.25 * v) <= 1]
        assert len(fits) == 1
        seen.update(fits)
        np.testing.assert_array_equal(out[..., 3], image[..., 3])
    assert seen == {0, 100, 200}
    np.testing.assert_array_equal(images.image_blend(image, str(folder), blendFactor=0.0), image)


def test_cut_mix_replaces_one_rectangle(folder):
    image = np.full((16, 12, 4), 50, np.uint8)
    sizes = []
    for seed in range(60):
        out = images.cut_mix(image, folderpath=str(folder), seed=seed)
        rows, columns = np.nonzero(out[..., 0] != 50)
        assert (out[..., 3] == 50).all()
        sizes.append(len(rows))
        if len(rows):
            patch = out[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1, :3]
            assert np.ptp(patch) == 0
            assert patch.flat[0] in (0, 100, 200)
    # The mean area of a rectangle with uniform corners is a ninth; 60 samples know it to a sixth of itself.
    assert np.mean(sizes) == pytest.approx(16 * 12 / 9, rel=0.5)


def test_background_rand_shows_through_alpha_and_where_nothing_is(folder):
    image = np.full((4, 6, 4), 60, np.uint8)
    image[..., 3] = 255
    image[:, :2, 3] = 0
    instance = np.zeros((4, 6), np.int32)
    instance[:, 4:] = -1
    out = images.background_rand(image, folderpath=str(folder), instance=instance, seed=1)
    assert len({*np.unique(out[:, :2, :3]), *np.unique(out[:, 4:, :3])} & {0, 100, 200}) == 1
    assert (out[:, 2:4, :3] == 60).all()
    np.testing.assert_array_equal(out[..., 3], image[..., 3])


@pytest.mark.parametrize("function", [images.image_blend, images.cut_mix, images.background_rand])
def test_a_folder_without_pictures_is_told(function, tmp_path):
    for path in ("", str(tmp_path), str(tmp_path / "nowhere")):
        with pytest.raises(AugmentationError, match="has no images"):
            function(picture(), folderpath=path)
    (tmp_path / "broken.png").write_bytes(b"no picture")
    with pytest.raises(AugmentationError, match=r"broken\.png cannot be read"):
        function(picture(), folderpath=str(tmp_path))


def test_pictures_are_resized_to_the_frame(tmp_path):
    Image.fromarray(smooth()[..., :3]).save(tmp_path / "one.png")
    out = images.image_blend(np.zeros((64, 80, 3), np.uint8), folderpath=str(tmp_path), blendFactor=1.0)
    assert apart(out[1::2, 1::2][:-1, :-1], smooth()[:-1, :-1, :3]) <= 12


def test_a_picture_that_was_replaced_is_read_again(tmp_path):
    for color in (40, 80):
        Image.new("RGB", (8, 8), (color, color, color)).save(tmp_path / "one.png")
        os.utime(tmp_path / "one.png", (color, color))
        out = images.image_blend(np.zeros((8, 8, 3), np.uint8), folderpath=str(tmp_path), blendFactor=1.0)
        assert (out == color).all()


# What older versions draw themselves


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("AugContrastExp", {"contrastFactorIntervalMin": 0.2, "contrastFactorIntervalMax": 5}),
        ("AugConv2dExp", {"alpha": 0.7, "kernelWidth": 3}),
        ("AugCropResizeExp", {"minPercent": 0.5}),
        ("AugRotateExp", {"rotateDegrees": 40.0}),
        ("AugMotionBlurExp", {"alpha": 0.7, "kernelSize": 11}),
    ],
)
def test_older_spellings_draw_for_every_frame(name, options):
    set_global_seed(1)  # of one in fifty seeds two frames draw the same kernel
    frame = make_frame(street(), (32, 24))
    annotator = annotators.get("rgb").augment(f"omni.replicator.core.{name}", **options)
    frames = [dataclasses.replace(frame, index=index, memo={}) for index in (0, 1, 0)]
    first, second, again = (annotator.compute(each) for each in frames)
    assert (first.data != second.data).any()
    np.testing.assert_array_equal(first.data, again.data)
    np.testing.assert_array_equal(first.info["xform"], again.info["xform"])


# All of them, by name


@pytest.mark.parametrize("name", DEFAULT_AUGMENTATIONS)
def test_each_works_by_name_on_what_it_is_for(name, folder):
    frame = make_frame(street(), (32, 24))
    source = {"ColorizeDepth": "distance_to_camera", "ColorizeNormals": "normals"}.get(name, "rgb")
    wants_folder = name in ("BackgroundRand", "BgRand", "CutMix", "ImageBlend", "ImgBlend")
    before = frame.aovs["LdrColor"].copy()
    annotator = annotators.get(source).augment(name, **({"folderpath": str(folder)} if wants_folder else {}))
    result = annotator.compute(frame)
    assert result.data.dtype == np.uint8
    assert result.data.shape[:2] == (24, 32)
    np.testing.assert_array_equal(result.data, annotator.compute(dataclasses.replace(frame, memo={})).data)
    np.testing.assert_array_equal(frame.aovs["LdrColor"], before)
    assert annotators.get_augmentation(name).documentation
