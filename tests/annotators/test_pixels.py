"""Kernels that write images in runs of pixels, against NumPy: odd sizes, all numbers of channels, odd values."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from usdsdg.annotators.pixels import encodings, look_ups
from usdsdg.annotators.pixels.launch import RUN_PIXELS
from usdsdg.annotators.pixels.look_up_table import LookUpTable

HEIGHT, WIDTH = 67, 101  # more than one run, and the last one is shorter
ODD = np.array(
    [np.nan, np.inf, -np.inf, -0.0, 65504, 65520, 1e30, 6e-8, -3, 0.5 / 255, 1.5 / 255, 1.0000001], np.float32
)


def image(channels: int, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    values = (10.0 ** rng.uniform(-8, 6, (HEIGHT, WIDTH, channels))).astype(np.float32)
    values.reshape(-1)[: 9 * len(ODD)] = np.tile(ODD, 9)
    return values if channels > 1 else values[..., 0]


def three_channels(values: np.ndarray) -> np.ndarray:
    if values.ndim == 2:
        return np.repeat(values[..., None], 3, axis=2)
    return np.pad(values, ((0, 0), (0, 0), (0, 2)))[..., :3]


def instances() -> np.ndarray:
    return np.random.default_rng(1).integers(-1, 5, (HEIGHT, WIDTH)).astype(np.int32)


def test_the_picture_takes_more_than_one_run():
    assert HEIGHT * WIDTH > RUN_PIXELS
    assert HEIGHT * WIDTH % RUN_PIXELS


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@pytest.mark.parametrize("limit", [np.inf, encodings.HALF_MAX])
@pytest.mark.filterwarnings("ignore:overflow:RuntimeWarning")
def test_halves(channels, limit):
    first, second, instance = image(channels), image(channels, seed=1), instances()
    with np.errstate(invalid="ignore"):
        added = three_channels(first) + three_channels(second)
    for found, expected, fourth in (
        (encodings.halves(first, limit=limit), three_channels(first), 1),
        (encodings.halves(first, limit=limit, plus=second, instance=instance), added, instance >= 0),
    ):
        limited = np.where(expected > limit, np.float32(limit), expected).astype(np.float16)
        assert np.array_equal(found[..., :3], limited, equal_nan=True)
        assert np.array_equal(found[..., 3], np.broadcast_to(fourth, (HEIGHT, WIDTH)))


@pytest.mark.parametrize("channels", [2, 3])
def test_floats(channels):
    values = image(channels)
    found = encodings.floats(values, 0.25)
    assert np.array_equal(found[..., :3], three_channels(values), equal_nan=True)
    assert (found[..., 3] == 0.25).all()


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_eight_bits(channels):
    values = np.nan_to_num(image(channels), nan=0.3)
    found = encodings.eight_bits(values)
    expected = np.clip(values, 0, 1) * np.float32(255) + np.float32(0.5)
    assert np.array_equal(found[..., :3], three_channels(expected).astype(np.uint8))
    fourth = expected[..., 3].astype(np.uint8) if channels == 4 else np.uint8(255)
    assert np.array_equal(found[..., 3], np.broadcast_to(fourth, (HEIGHT, WIDTH)))


@pytest.mark.filterwarnings("ignore:overflow:RuntimeWarning")
def test_without_alpha_and_behind_everything():
    color, instance = (np.nan_to_num(image(4)) * 100).astype(np.float16), instances()
    assert np.array_equal(encodings.behind_everything(color, instance), np.where(instance[..., None] < 0, color, 0))
    colors = np.random.default_rng(0).integers(0, 256, (HEIGHT, WIDTH, 4)).astype(np.uint8)
    assert np.array_equal(encodings.without_alpha(colors), colors[..., :3])


@pytest.mark.parametrize("words", [1, 2, 3, 4, 6])
def test_look_up_takes_the_last_entry_where_nothing_is_hit(words):
    table, instance = np.random.default_rng(0).random((6, words)).astype(np.float32), instances()
    assert np.array_equal(look_ups.look_up(instance, LookUpTable(table)), table[instance])


def test_pictures_that_lie_one_after_the_other_are_looked_up_together():
    shown = np.random.default_rng(1).integers(-1, 5, (3, HEIGHT, WIDTH)).astype(np.int32)
    whole = wp.array(shown, dtype=wp.int32, device="cpu")
    colors = np.random.default_rng(2).integers(0, 256, (6, 4)).astype(np.uint8)
    for order in ([0, 1, 2], [2, 0]):  # in a row, and not
        found = look_ups.look_up_all([whole[k] for k in order], LookUpTable(colors))
        for k, image in zip(order, found, strict=True):
            assert np.array_equal(image.numpy(), colors[shown[k]])
    assert look_ups.look_up_all([whole[0]], LookUpTable(colors))[0].shape == (HEIGHT, WIDTH, 4)


def test_shade():
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(HEIGHT, WIDTH, 3)).astype(np.float32)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    colors, instance, light = rng.uniform(0, 255, (6, 3)), instances(), np.array([0.6, 0.0, 0.8], np.float32)
    found = look_ups.shade(instance, normals, colors, light, 0.5)
    expected = colors[instance] * (0.5 + 0.25 * (normals @ light + 1))[..., None]
    # Whole numbers are cut off, so that rounding may move a value by one.
    assert np.abs(found.astype(int) - np.floor(expected)).max() <= 1
    assert (found == np.floor(expected)).mean() > 0.999


def test_points_of_kept_gprims_are_gathered_row_by_row():
    rng, instance = np.random.default_rng(0), instances()
    kept = np.array([True, False, True, False, False, True])  # the last one is of pixels that show nothing
    tables = {name: rng.integers(0, 99, 6) for name in ("classes", "ids")}
    images = {name: rng.random((HEIGHT, WIDTH, 3)).astype(np.float32) for name in ("position", "normals")}
    images["LdrColor"] = rng.integers(0, 256, (HEIGHT, WIDTH, 4)).astype(np.uint8)
    points, normals, colors, classes, ids = look_ups.gather_points(instance, kept, tables, images)
    shown = kept[instance]
    assert np.array_equal(points, images["position"][shown])
    assert np.array_equal(normals[:, :3], images["normals"][shown])
    assert (normals[:, 3] == 1).all()
    assert np.array_equal(colors, images["LdrColor"][shown])
    assert np.array_equal(classes, tables["classes"][instance[shown]])
    assert np.array_equal(ids, tables["ids"][instance[shown]])
