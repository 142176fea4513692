"""Powers of the denoiser against NumPy's in double precision."""

from __future__ import annotations

import numpy as np
import warp as wp

from tests.render.images import DEVICE
from usdsdg.parallel import CUDA_BLOCK
from usdsdg_render.kernels.powers import exp_of_minus, power_64


@wp.kernel(enable_backward=False)
def raise_all(
    x: wp.array(dtype=wp.float32), exponentials: wp.array(dtype=wp.float32), powers: wp.array(dtype=wp.float32)
):
    i = wp.tid()
    exponentials[i] = exp_of_minus(x[i])
    powers[i] = power_64(x[i])


def raised(x):
    values = wp.array(x, dtype=wp.float32, device=DEVICE)
    out = [wp.zeros(len(x), dtype=wp.float32, device=DEVICE) for _ in range(2)]
    wp.launch(raise_all, len(x), [values], out, device=DEVICE, block_dim=CUDA_BLOCK)
    return [each.numpy().astype(np.float64) for each in out]


def test_exponentials():
    x = np.concatenate([np.linspace(0, 1, 1001), np.geomspace(1e-6, 80, 2001)]).astype(np.float32)
    exact = np.exp(-x.astype(np.float64))
    found = raised(x)[0]
    # The argument's rounding error grows with it: x / ln 2 is a float.
    assert (np.abs(found / exact - 1) < 4e-7 + 1.2e-7 * x).all()
    assert abs(found[0] - 1) < 1e-7


def test_exponentials_of_large_numbers_are_zero():
    found = raised(np.array([88.0, 100.0, 1e10, np.inf], np.float32))[0]
    assert (found < 1e-37).all()
    assert (found >= 0).all()


def test_powers():
    x = np.linspace(0, 1, 501).astype(np.float32)
    np.testing.assert_allclose(raised(x)[1], x.astype(np.float64) ** 64, rtol=64 * 6e-8, atol=1e-37)
