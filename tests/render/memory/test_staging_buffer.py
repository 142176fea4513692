"""Staging buffers: memory that the host writes and a device reads."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from usdsdg_render.memory.staging_buffer import CACHE_LINE, StagingBuffer, aligned
from usdsdg_render.scene.structs import Hit

DEVICES = ["cpu", *(device.alias for device in wp.get_cuda_devices())]


@pytest.mark.parametrize("shape", [(1,), (3, 5), (700, 80)])
def test_aligned_arrays_start_at_a_cache_line(shape):
    for _ in range(20):
        array = aligned(shape, np.float32)
        assert array.shape == shape
        assert array.ctypes.data % CACHE_LINE == 0


@pytest.mark.parametrize("device", DEVICES)
def test_a_device_reads_what_was_uploaded(device):
    staging = StagingBuffer(64, device)
    staging.host[:] = np.arange(64)
    staging.upload(64)
    words = staging.array(16, 3, wp.int32)
    np.testing.assert_array_equal(words.numpy(), staging.host[16:28].view(np.int32))
    assert words.ptr == staging.address(16)
    staging.host[:] = 7
    staging.upload(20)
    first, second, _ = words.numpy().view(np.uint8).reshape(3, 4)
    assert (first == 7).all()
    assert (second == (7 if device == "cpu" else np.arange(20, 24))).all()


@pytest.mark.parametrize("device", DEVICES)
def test_records_are_read_in_place(device):
    dtype = np.dtype(Hit.numpy_dtype())
    staging = StagingBuffer(5 * dtype.itemsize, device)
    rows = staging.host.view(dtype)
    rows["t"], rows["instance"] = np.arange(5), np.arange(5) - 1
    staging.upload(staging.host.nbytes)
    found = staging.array(dtype.itemsize, 4, Hit).numpy()
    np.testing.assert_array_equal(found["t"], [1, 2, 3, 4])
    np.testing.assert_array_equal(found["instance"], [0, 1, 2, 3])
