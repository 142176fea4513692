"""Memory that is written on the host and read on a device."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from usdsdg_render.memory.staging_buffer import LINE, Mirror, aligned
from usdsdg_render.scene.structs import Hit

DEVICES = ["cpu", *(device.alias for device in wp.get_cuda_devices())]


@pytest.mark.parametrize("shape", [(1,), (3, 5), (700, 80)])
def test_aligned_arrays_start_lines(shape):
    for _ in range(20):
        array = aligned(shape, np.float32)
        assert array.shape == shape
        assert array.ctypes.data % LINE == 0


@pytest.mark.parametrize("device", DEVICES)
def test_a_device_reads_what_was_sent(device):
    mirror = Mirror(64, device)
    mirror.host[:] = np.arange(64)
    mirror.send(64)
    words = mirror.array(16, 3, wp.int32)
    np.testing.assert_array_equal(words.numpy(), mirror.host[16:28].view(np.int32))
    assert words.ptr == mirror.address(16)
    mirror.host[:] = 7
    mirror.send(20)
    first, second, _ = words.numpy().view(np.uint8).reshape(3, 4)
    assert (first == 7).all()
    assert (second == (7 if device == "cpu" else np.arange(20, 24))).all()


@pytest.mark.parametrize("device", DEVICES)
def test_records_are_read_where_they_lie(device):
    dtype = np.dtype(Hit.numpy_dtype())
    mirror = Mirror(5 * dtype.itemsize, device)
    rows = mirror.host.view(dtype)
    rows["t"], rows["instance"] = np.arange(5), np.arange(5) - 1
    mirror.send(mirror.host.nbytes)
    found = mirror.array(dtype.itemsize, 4, Hit).numpy()
    np.testing.assert_array_equal(found["t"], [1, 2, 3, 4])
    np.testing.assert_array_equal(found["instance"], [0, 1, 2, 3])
