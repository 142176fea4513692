"""Trigonometric polynomials against NumPy."""

import numpy as np
import pytest
import warp as wp

from usdsdg_render.kernels.trig import acos_over_pi, azimuth_turns, cos_sin


@wp.kernel(enable_backward=False)
def evaluate(
    x: wp.array(dtype=wp.float32),
    y: wp.array(dtype=wp.float32),
    # out
    around: wp.array(dtype=wp.vec2),
    turns: wp.array(dtype=wp.float32),
    from_pole: wp.array(dtype=wp.float32),
):
    i = wp.tid()
    around[i] = cos_sin(x[i])
    turns[i] = azimuth_turns(x[i], y[i])
    from_pole[i] = acos_over_pi(wp.clamp(x[i], -1.0, 1.0))


def evaluated(x: np.ndarray, y: np.ndarray) -> list[np.ndarray]:
    outputs = [wp.zeros(len(x), dtype=dtype, device="cpu") for dtype in (wp.vec2, wp.float32, wp.float32)]
    inputs = [wp.array(each, dtype=wp.float32, device="cpu") for each in (x, y)]
    wp.launch(evaluate, dim=len(x), inputs=inputs, outputs=outputs, device="cpu")
    return [each.numpy() for each in outputs]


def test_polynomials_match_numpy():
    rng = np.random.default_rng(0)
    x = np.concatenate([rng.uniform(-1.2, 1.2, 20000), np.arange(-4, 5) / 4, 1 - np.geomspace(1e-7, 1, 50)])
    y = np.concatenate([rng.uniform(-1.2, 1.2, 20000), np.arange(-4, 5) / -4, np.zeros(50)])
    x, y = x.astype(np.float32), y.astype(np.float32)
    around, turns, from_pole = evaluated(x, y)
    angle = 2 * np.pi * x.astype(float)
    np.testing.assert_allclose(around, np.stack([np.cos(angle), np.sin(angle)], -1), atol=5e-7)
    expected = np.arctan2(y, x, dtype=float) / (2 * np.pi)
    apart = np.abs(turns - expected)
    assert np.minimum(apart, np.abs(apart - 1)).max() < 3e-7
    assert turns.min() >= 0
    assert turns.max() <= 1
    np.testing.assert_allclose(from_pole, np.arccos(np.clip(x.astype(float), -1, 1)) / np.pi, atol=3e-7)


@pytest.mark.parametrize(("x", "y", "turns"), [(1, 0, 0.0), (0, 1, 0.25), (-1, 0, 0.5), (0, -1, 0.75), (0, 0, 0.0)])
def test_axes_are_exact(x, y, turns):
    assert evaluated(np.float32([x]), np.float32([y]))[1][0] == turns
