"""Zlib streams with Huffman codes and runs of equal bytes, and no other matches: the same bytes on every CPU.

Our own, because it suits the filtered rows of rendered images: a path-traced 1080p picture takes a third of the time of
libdeflate's fastest level for a file as small, and a label map a tenth. ISA-L, which is nearly as fast, finds its first
matches by the address of its own stack, and so writes other bytes in some threads (`.write_first_byte` in
igzip_icf_body_h1_gr_bt.asm).

Source: RFC 1950 (zlib), RFC 1951 (deflate).
"""

import threading
from functools import lru_cache
from typing import Any

import numpy as np

from usdsdg.warp_start import loaded_on_cpu

# Bytes that share their codes.
BLOCK = 1 << 18
_HEAD = b"\x78\x01"  # a window of 32 KiB, fastest compression
_WIDTH = 5
_SYMBOLS, _FIRST_RUN, _TOKENS = 286, 257, 515
# Bits behind the codes of lengths 3 to 258, from symbol 257 on.
_EXTRA = (0,) * 8 + (1,) * 4 + (2,) * 4 + (3,) * 4 + (4,) * 4 + (5,) * 4
# Lengths of the codes in which the lengths of codes are listed: the same for all blocks. 18 is for many zeros.
_LIST_LENGTHS = {
    18: 2,
    **dict.fromkeys((0, 3, 4, 5, 6, 7, 8, 9), 4),
    **dict.fromkeys((1, 2, 10, 11, 12, 13, 14, 15), 5),
}
_LIST_ORDER = (16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15)
_of_thread = threading.local()


def compress(data: np.ndarray, *, distance: int = 1) -> bytes:
    """Return the zlib stream of a contiguous uint8 array of any shape; see `compressed_chunks`."""
    return b"".join(compressed_chunks(data, distance=distance))


def compressed_chunks(data: np.ndarray, *, distance: int = 1) -> tuple[bytes, memoryview, bytes]:
    """Return the zlib stream of a contiguous uint8 array of any shape, in pieces of which the largest is not copied.

    distance: 1 finds runs of equal bytes; 2, 3 and 4 find repetitions of so many bytes.

    Raises:
        ValueError: it is empty.
    """
    if not data.size:
        raise ValueError("no bytes to compress")
    import warp as wp

    kernel = loaded_on_cpu(_kernel)
    source = data.reshape(-1)
    stream = np.empty(2 * source.size + 1024, np.uint8)  # no code has more than 15 bits
    place = np.empty(2, np.int64)
    inputs = [_wrapped(source), BLOCK, *_tables(distance), *_scratch(), _wrapped(stream), _wrapped(place)]
    wp.launch(kernel, dim=1, inputs=inputs, device="cpu")
    bits, adler = place.tolist()
    return _HEAD, stream[: (bits + 7) // 8].data, adler.to_bytes(4, "big")


def load() -> None:
    """Load warp and the kernel; see `loaded_on_cpu`."""
    loaded_on_cpu(_kernel)


def _wrapped(array: np.ndarray) -> Any:
    import warp as wp

    return wp.array(array, device="cpu", copy=False)


def _scratch() -> list[Any]:
    """Return arrays that a call fills before it reads them, of the calling thread."""
    if not hasattr(_of_thread, "scratch"):
        shapes = [(BLOCK, np.uint16), (2 * _TOKENS, np.uint32), ((4, 2 * _SYMBOLS), np.int32)]
        shapes += [((2, 2 * _SYMBOLS), np.uint32), (_TOKENS, np.uint32)]
        _of_thread.scratch = [_wrapped(np.zeros(shape, kind)) for shape, kind in shapes]
    return _of_thread.scratch


def _kernel() -> Any:
    from usdsdg.image_files.run_kernels import deflate_runs

    return deflate_runs


@lru_cache(maxsize=4)
def _tables(distance: int) -> list[Any]:
    """Return what is the same for all blocks: the kernel's inputs from `run_symbols` to `head`.

    Bits stand above the number of them, which has 5 bits.
    """
    symbols, extra = np.zeros(259, np.int32), np.zeros(259, np.uint32)
    length = 3
    for symbol, bits in enumerate(_EXTRA, _FIRST_RUN):
        for value in range(1 << bits):
            if length < 259:
                symbols[length], extra[length] = symbol, value << _WIDTH | bits
            length += 1
    symbols[258], extra[258] = _SYMBOLS - 1, 0
    codes = np.zeros(19, np.uint32)
    code = depth = 0
    for listed, bits in sorted(_LIST_LENGTHS.items(), key=lambda item: (item[1], item[0])):
        code, depth = code << (bits - depth), bits
        codes[listed] = int(f"{code:0{bits}b}"[::-1], 2) << _WIDTH | bits
        code += 1
    kinds = [(2, 2), (_SYMBOLS - 257, 5), (distance - 1, 5), (len(_LIST_ORDER) - 4, 4)]
    kinds += [(_LIST_LENGTHS.get(listed, 0), 3) for listed in _LIST_ORDER]
    head = np.array([value << _WIDTH | bits for value, bits in kinds], np.uint32)
    return [_wrapped(symbols), _wrapped(extra), _wrapped(codes), distance, _wrapped(head)]
