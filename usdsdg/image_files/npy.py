"""Arrays as the bytes of a .npy file, which `numpy.load` reads: those of `numpy.save`, without copies of the array."""

import io

import numpy as np


def npy_chunks(array: np.ndarray, *, allow_pickle: bool = True) -> tuple[bytes | memoryview, ...]:
    """Return the bytes of the file in pieces; the array must not be modified until they are written.

    Raises:
        ValueError: it is an array of objects, and `allow_pickle` is False.
    """
    head = io.BytesIO()
    try:
        if array.dtype.hasobject:
            raise ValueError("objects are pickled")
        np.lib.format.write_array_header_1_0(head, np.lib.format.header_data_from_array_1_0(array))
    except ValueError:  # also a type whose description is too long for this version of the header
        whole = io.BytesIO()
        np.save(whole, array, allow_pickle=allow_pickle)
        return (whole.getvalue(),)
    columns_first = array.flags.f_contiguous and not array.flags.c_contiguous
    content = np.ascontiguousarray(array.T if columns_first else array)
    return head.getvalue(), content.reshape(-1).view(np.uint8).data
