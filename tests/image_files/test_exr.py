"""EXR files: written and read again, and read when others wrote them."""

import struct
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from usdsdg.errors import AssetUnreadable, Unsupported
from usdsdg.image_files import exr

SHAPES = st.tuples(st.integers(1, 40), st.integers(1, 9)) | st.tuples(
    st.integers(1, 40), st.integers(1, 9), st.integers(2, 4)
)


@given(st.sampled_from([np.float32, np.float16, np.uint32]).flatmap(lambda kind: arrays(kind, SHAPES)))
@settings(deadline=None)
def test_writing_is_undone_by_reading(image):
    read = exr.decode(exr.encode(image))
    assert read.dtype == image.dtype
    np.testing.assert_array_equal(read, image)


def test_halves_and_other_numbers():
    image = np.random.default_rng(0).uniform(0, 9, (20, 30, 3))
    np.testing.assert_array_equal(exr.decode(exr.encode(image, half=True)), image.astype(np.float16))
    np.testing.assert_array_equal(exr.decode(exr.encode(image)), image.astype(np.float32))
    assert exr.decode(exr.encode(np.full((2, 2), 7, np.int16))).dtype == np.uint32


def test_smooth_images_are_compressed_and_flat_parts_more():
    image = np.broadcast_to(np.linspace(0, 1, 256, dtype=np.float32), (256, 256))
    assert len(exr.encode(image)) < image.nbytes / 2
    flat = np.repeat(image[:, ::32], 32, axis=1)
    assert len(exr.encode(flat)) < flat.nbytes / 16


def recompressed(image, compression):
    """The file that another program would have written: not compressed (0), or each line by itself with ZIPS (2)."""
    data = exr.encode(image)
    last = b"screenWindowWidth\0float\0"
    head = data[: data.index(last) + len(last) + 9]
    stored = b"compression\0compression\0\x01\0\0\0"
    head = head.replace(stored + b"\x03", stored + bytes([compression]))
    chunks = []
    for y, line in enumerate(np.moveaxis(image[..., ::-1], 2, 1)):
        raw = np.ascontiguousarray(line).tobytes()
        packed = zlib.compress(exr._split_and_differenced(raw)) if compression else raw
        body = packed if len(packed) < len(raw) else raw
        chunks.append(struct.pack("<ii", y, len(body)) + body)
    offsets = np.cumsum([len(head) + 8 * len(chunks), *(len(chunk) for chunk in chunks[:-1])])
    return b"".join([head, offsets.astype("<u8").tobytes(), *chunks])


@pytest.mark.parametrize("compression", [0, 2])
def test_other_compressions_are_read(compression):
    image = np.random.default_rng(0).integers(0, 3, (5, 70, 3)).astype(np.float32)
    np.testing.assert_array_equal(exr.decode(recompressed(image, compression)), image)


def test_runs_are_expanded():
    assert exr._run_length_decoded(bytes([2, 7, 256 - 3, 1, 2, 3, 0, 9])) == bytes([7, 7, 7, 1, 2, 3, 9])


@pytest.mark.parametrize(
    "image", [np.zeros((2, 2, 5)), np.zeros(3), np.zeros((0, 2)), np.zeros((2, 2), "U1"), np.array([[-1]])]
)
def test_what_a_file_cannot_hold_is_told(image):
    with pytest.raises(ValueError, match="an EXR file cannot hold"):
        exr.encode(image)


def test_what_cannot_be_read_is_told():
    data = exr.encode(np.ones((4, 4), np.float32))
    with pytest.raises(AssetUnreadable, match=r"sky\.exr is not an EXR file"):
        exr.decode(b"#?RADIANCE", name="sky.exr")
    for end in (10, 100, len(data) - 3):
        with pytest.raises(AssetUnreadable, match="damaged"):
            exr.decode(data[:end])
    with pytest.raises(Unsupported, match="tiles"):
        exr.decode(data[:5] + b"\x02" + data[6:])
    with pytest.raises(Unsupported, match="PIZ"):
        exr.decode(data.replace(b"\x01\0\0\0\x03", b"\x01\0\0\0\x04"))


def test_the_files_agree_with_openexr(tmp_path):
    OpenEXR = pytest.importorskip("OpenEXR")
    image = np.random.default_rng(0).normal(size=(33, 21, 3)).astype(np.float32)
    (tmp_path / "ours.exr").write_bytes(exr.encode(image))
    with OpenEXR.File(str(tmp_path / "ours.exr")) as file:
        np.testing.assert_array_equal(file.channels()["RGB"].pixels, image)
    for compression in ("NO", "RLE", "ZIPS", "ZIP"):
        header = {"compression": getattr(OpenEXR, f"{compression}_COMPRESSION"), "type": OpenEXR.scanlineimage}
        with OpenEXR.File(header, {"RGB": image}) as file:
            file.write(str(tmp_path / "theirs.exr"))
        np.testing.assert_array_equal(exr.decode((tmp_path / "theirs.exr").read_bytes()), image)
