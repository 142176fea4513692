"""A buffer returns to the pool when the last array that refers to it is deleted, and not before."""

from __future__ import annotations

import numpy as np
import warp as wp

from usdsdg import buffers
from usdsdg.buffers import BufferPool, PooledBuffer
from usdsdg.readback import read_back


class Bytes:
    """Host memory with an address."""

    def __init__(self, size: int) -> None:
        self.values = np.zeros(size, np.uint8)
        self.ptr = self.values.ctypes.data


def pooled_array(pool: BufferPool, count: int) -> np.ndarray | None:
    buffer = pool.acquire(4 * count)
    return None if buffer is None else np.asarray(PooledBuffer(pool, buffer, 4 * count, (count,), "<f4"))


def test_memory_is_reused_only_when_no_view_is_left():
    pool = BufferPool(Bytes, 1000)
    first = pooled_array(pool, 6)
    address = first.ctypes.data
    first[:] = 7.0
    row = first.reshape(2, 3)[1]
    del first
    other = pooled_array(pool, 6)
    assert other.ctypes.data != address
    other[:] = 1.0
    assert (row == 7.0).all()
    del row
    assert pooled_array(pool, 6).ctypes.data == address


def test_the_pool_stays_within_its_limit():
    pool = BufferPool(Bytes, max_bytes=100)
    held = pooled_array(pool, 10)
    again = pooled_array(pool, 15)
    assert again is not None
    assert pooled_array(pool, 1) is None
    del again
    # Unused buffers are freed for another size.
    assert pooled_array(pool, 5) is not None
    assert pooled_array(pool, 16) is None
    assert held.size == 10


def test_arrays_of_nearly_the_same_size_share_a_few_buffers():
    sizes = []
    pool = BufferPool(lambda size: sizes.append(size) or Bytes(size), max_bytes=1 << 22)
    counts = np.random.default_rng(0).integers(40_000, 60_000, 300)  # points in view, frame by frame
    for count in counts.tolist():
        array = pooled_array(pool, count)
        array[-1] = 1.0  # the last byte is there
        del array
    assert len(sizes) <= 6
    assert all(any(4 * count <= size <= 4 * count * 9 / 8 for size in sizes) for count in counts.tolist())


def test_room_is_made_of_as_few_unused_buffers_as_needed():
    sizes = []
    pool = BufferPool(lambda size: sizes.append(size) or Bytes(size), max_bytes=400)
    first, second = pooled_array(pool, 50), pooled_array(pool, 25)
    address = second.ctypes.data
    del first, second
    assert pooled_array(pool, 60) is not None  # in place of the first
    assert pooled_array(pool, 25).ctypes.data == address
    assert sizes == [208, 104, 240]


def test_cpu_arrays_are_not_copied():
    array = wp.array([[1.0, 2.0, 3.0]], dtype=wp.vec3, device="cpu")
    copies = read_back({"a": array, "none": wp.empty((0, 4), dtype=wp.int32, device="cpu")})
    assert copies["a"].tolist() == [[1.0, 2.0, 3.0]]
    assert copies["a"].ctypes.data == array.ptr
    assert copies["none"].shape == (0, 4)


def test_images_of_dropped_arrays_are_used_again():
    first = buffers.empty((300, 200, 4), np.float16)
    assert first.shape == (300, 200, 4)
    assert first.dtype == np.float16
    address = first.ctypes.data
    first[:] = 1.0
    del first
    second = buffers.empty((200, 300, 2), np.float32)
    assert second.ctypes.data == address
    kept = second[5:]
    del second
    assert buffers.empty((200, 300, 2), np.float32).ctypes.data != address
    assert kept.shape == (195, 300, 2)


def test_arrays_of_new_memory_are_as_those_of_used_memory():
    small = buffers.empty((2, 3), np.uint8)
    assert small.shape == (2, 3)
    assert small.base is None
    assert buffers.empty((0, 4), np.float32).shape == (0, 4)
