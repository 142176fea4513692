"""What is lent to arrays comes back when the last of them is gone, and not before."""

from __future__ import annotations

import numpy as np
import warp as wp

from usdsdg_render.memory.readback import Loan, Pool, fetch


class Bytes:
    """Host memory with an address."""

    def __init__(self, size: int) -> None:
        self.values = np.zeros(size, np.uint8)
        self.ptr = self.values.ctypes.data


def lend(pool: Pool, count: int) -> np.ndarray | None:
    buffer = pool.take(4 * count)
    return None if buffer is None else np.asarray(Loan(pool, buffer, 4 * count, (count,), "<f4"))


def test_memory_is_used_again_only_when_no_view_is_left():
    pool = Pool(Bytes)
    first = lend(pool, 6)
    address = first.ctypes.data
    first[:] = 7.0
    row = first.reshape(2, 3)[1]
    del first
    other = lend(pool, 6)
    assert other.ctypes.data != address
    other[:] = 1.0
    assert (row == 7.0).all()
    del row
    assert lend(pool, 6).ctypes.data == address


def test_there_is_no_more_than_allowed():
    pool = Pool(Bytes, most=100)
    held = lend(pool, 10)
    again = lend(pool, 15)
    assert again is not None
    assert lend(pool, 1) is None
    del again
    # What is not lent makes room for another size.
    assert lend(pool, 5) is not None
    assert lend(pool, 16) is None
    assert held.size == 10


def test_arrays_of_a_cpu_are_themselves():
    array = wp.array([[1.0, 2.0, 3.0]], dtype=wp.vec3, device="cpu")
    fetched = fetch({"a": array, "none": wp.empty((0, 4), dtype=wp.int32, device="cpu")})
    assert fetched["a"].tolist() == [[1.0, 2.0, 3.0]]
    assert fetched["a"].ctypes.data == array.ptr
    assert fetched["none"].shape == (0, 4)
