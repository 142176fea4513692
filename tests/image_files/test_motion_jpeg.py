"""Videos: read back box by box as the standard has them, and by FFmpeg where PyAV is installed."""

import io
import struct

import numpy as np
import pytest
from PIL import Image

from usdsdg.errors import WriterError
from usdsdg.image_files.motion_jpeg import Video, encode_frame

CONTAINERS = {b"moov", b"trak", b"mdia", b"minf", b"dinf", b"stbl"}


def boxes(data: bytes, start: int = 0, end: int | None = None) -> dict[bytes, tuple[int, int]]:
    """Where the content of every box lies, by its kind; each kind stands once in our files."""
    found: dict[bytes, tuple[int, int]] = {}
    offset, end = start, len(data) if end is None else end
    while offset < end:
        size, kind = struct.unpack_from(">I4s", data, offset)
        head = 8
        if size == 1:
            (size,) = struct.unpack_from(">Q", data, offset + 8)
            head = 16
        assert size >= head
        assert kind not in found
        found[kind] = (offset + head, offset + size)
        if kind in CONTAINERS:
            found |= boxes(data, *found[kind])
        offset += size
    assert offset == end, "sizes add up"
    return found


def images_of(data: bytes) -> list[np.ndarray]:
    """Return the images of a video, by its tables of sizes and offsets."""
    found = boxes(data)
    common, count = struct.unpack_from(">2I", data, found[b"stsz"][0] + 4)
    assert common == 0
    sizes = struct.unpack_from(f">{count}I", data, found[b"stsz"][0] + 12)
    chunks, offset = struct.unpack_from(">2I", data, found[b"stco"][0] + 4)
    assert chunks == 1
    assert found[b"mdat"] == (offset, offset + sum(sizes))
    images = []
    for size in sizes:
        with Image.open(io.BytesIO(data[offset : offset + size])) as image:
            images.append(np.asarray(image))
        offset += size
    return images


def encode_video(frames: list[bytes], size: tuple[int, int], rate: float) -> bytes:
    video = Video(size, rate)
    for frame in frames:
        video.append(frame)
    data = b"".join(video)
    assert data == b"".join(video)
    return data


def ramps(count: int = 5) -> list[np.ndarray]:
    """Smooth images (30, 44, 3) that differ."""
    y, x = np.mgrid[:30, :44]
    return [np.dstack([x * 5, y * 8, np.full_like(x, 40 * n)]).astype(np.uint8) for n in range(count)]


def test_frames_are_read_back():
    video = encode_video([encode_frame(each) for each in ramps()], (44, 30), 24)
    read = images_of(video)
    assert len(read) == 5
    for ours, theirs in zip(ramps(), read):
        assert np.abs(ours.astype(int) - theirs).mean() < 1


def test_rate_duration_and_size():
    video = encode_video([encode_frame(each) for each in ramps()], (44, 30), 29.97)
    found = boxes(video)
    assert list(found)[:2] == [b"ftyp", b"mdat"]
    clock, duration = struct.unpack_from(">2I", video, found[b"mdhd"][0] + 12)
    assert duration / clock == pytest.approx(5 / 29.97)
    assert struct.unpack_from(">3I", video, found[b"stts"][0] + 4) == (1, 5, 1000)
    assert [side >> 16 for side in struct.unpack_from(">2I", video, found[b"tkhd"][1] - 8)] == [44, 30]


def test_ffmpeg_reads_it(tmp_path):
    av = pytest.importorskip("av")
    (tmp_path / "video.mp4").write_bytes(encode_video([encode_frame(each) for each in ramps()], (44, 30), 24))
    with av.open(str(tmp_path / "video.mp4")) as container:
        stream = container.streams.video[0]
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)]
        assert (stream.codec_context.name, stream.average_rate) == ("mjpeg", 24)
    assert len(frames) == 5
    for ours, theirs in zip(ramps(), frames):
        assert np.abs(ours.astype(int) - theirs).mean() < 1.5


@pytest.mark.parametrize("shape", [(6, 9), (6, 9, 1), (6, 9, 3), (6, 9, 4)])
def test_gray_and_alpha(shape):
    with Image.open(io.BytesIO(encode_frame(np.full(shape, 90, np.uint8)))) as image:
        assert (image.mode, image.size) == ("RGB", (9, 6))
        assert np.abs(np.asarray(image).astype(int) - 90).max() <= 2


@pytest.mark.parametrize(("images", "rate"), [([], 24), ([b""], 0)])
def test_videos_without_frames_or_rate_are_refused(images, rate):
    with pytest.raises(WriterError, match="cannot be written"):
        encode_video(images, (4, 4), rate)
