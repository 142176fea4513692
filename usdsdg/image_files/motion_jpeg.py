"""Motion JPEG video in an MP4 file: every frame is a JPEG.

Our own, because it needs no codec library (PyAV and imageio-ffmpeg bundle FFmpeg) and gives the same bytes on every
machine. Players and readers based on FFmpeg (OpenCV, PyAV, decord, torchvision, VLC) support it; browsers do not.

Source: ISO/IEC 14496-12 (boxes), 14496-1 (descriptors).
"""

import io
import struct
import tempfile
from array import array
from collections.abc import Iterator, Sequence

import numpy as np

from usdsdg.errors import WriterError, counted

_QUALITY = 95
_TICKS = 1000  # of the video's clock per frame
_MATRIX = struct.pack(">9I", 0x10000, 0, 0, 0, 0x10000, 0, 0, 0, 0x40000000)
_JPEG = 0x6C  # object type of the codec in MPEG-4
_UNDETERMINED = 0x55C4  # language code "und"


def encode_frame(image: np.ndarray) -> bytes:
    """Encode a uint8 image (H, W), (H, W, 1), (H, W, 3) or (H, W, 4) as JPEG 4:4:4; alpha is dropped."""
    from PIL import Image

    image = image[..., 0] if image.ndim == 3 and image.shape[2] == 1 else image
    colors = np.stack([image] * 3, axis=-1) if image.ndim == 2 else image[..., :3]
    buffer = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(colors)).save(buffer, "JPEG", quality=_QUALITY, subsampling=0)
    return buffer.getvalue()


class Video:
    """An MP4 file of JPEG frames, which are in a temporary file until it is written."""

    def __init__(self, size: tuple[int, int], rate: float) -> None:
        """size: width and height [pixels]. rate: frames per second."""
        self._size, self._rate = size, rate
        self._frames = tempfile.TemporaryFile()  # noqa: SIM115 - closed with this object
        self._lengths = array("I")

    def append(self, frame: bytes) -> None:
        """Add a frame, as `encode_frame` returns it."""
        self._frames.seek(0, io.SEEK_END)
        self._frames.write(frame)
        self._lengths.append(len(frame))

    def __iter__(self) -> Iterator[bytes]:
        """Yield the parts of the file, one frame at a time; they may be gone over several times.

        Raises:
            WriterError: there are no frames, or the rate is not positive.
        """
        if not self._lengths or self._rate <= 0:
            raise WriterError(
                f"A video of {counted(len(self._lengths), 'frame')} at {self._rate} per second cannot be written; both "
                "must be above 0."
            )
        head = _box(b"ftyp", b"isom", struct.pack(">I", 0x200), b"isomiso2mp41")
        # A 64-bit size, since clips may exceed 4 GiB.
        yield head + struct.pack(">I4sQ", 1, b"mdat", 16 + sum(self._lengths))
        self._frames.seek(0)
        for length in self._lengths:
            yield self._frames.read(length)
        yield _movie(self._lengths, self._size, self._rate, offset=len(head) + 16)


def _movie(lengths: Sequence[int], size: tuple[int, int], rate: float, *, offset: int) -> bytes:
    """Build the "moov" box of frames that are stored one after the other from `offset` on."""
    clock, duration = round(rate * _TICKS), len(lengths) * _TICKS
    width, height = size
    movie_head = struct.pack(">4I I H 10x", 0, 0, clock, duration, 0x10000, 0x100) + _MATRIX + struct.pack(">24x I", 2)
    track_head = (
        struct.pack(">5I 8x 4H", 0, 0, 1, 0, duration, 0, 0, 0, 0)
        + _MATRIX
        + struct.pack(">2I", width << 16, height << 16)
    )
    samples = _box(
        b"stbl",
        _full(b"stsd", struct.pack(">I", 1), _format(width, height)),
        _full(b"stts", struct.pack(">3I", 1, len(lengths), _TICKS)),
        _full(b"stsc", struct.pack(">4I", 1, 1, len(lengths), 1)),
        _full(b"stsz", struct.pack(f">2I{len(lengths)}I", 0, len(lengths), *lengths)),
        _full(b"stco", struct.pack(">2I", 1, offset)),
    )
    media = _box(
        b"mdia",
        _full(b"mdhd", struct.pack(">4I 2H", 0, 0, clock, duration, _UNDETERMINED, 0)),
        _full(b"hdlr", struct.pack(">I4s12x", 0, b"vide"), b"VideoHandler\0"),
        _box(
            b"minf",
            _full(b"vmhd", struct.pack(">4H", 0, 0, 0, 0), flags=1),
            _box(b"dinf", _full(b"dref", struct.pack(">I", 1), _full(b"url ", flags=1))),
            samples,
        ),
    )
    track = _box(b"trak", _full(b"tkhd", track_head, flags=3), media)
    return _box(b"moov", _full(b"mvhd", movie_head), track)


def _format(width: int, height: int) -> bytes:
    """Build the sample entry of the track: JPEG of this size."""
    config = _descriptor(0x04, struct.pack(">2B 3s 2I", _JPEG, 0x11, b"\0\0\0", 0, 0))
    stream = _descriptor(0x03, struct.pack(">HB", 1, 0), config, _descriptor(0x06, b"\x02"))
    entry = struct.pack(">6xH 16x 2H 2I 4x H 32x Hh", 1, width, height, 0x480000, 0x480000, 1, 24, -1)
    return _box(b"mp4v", entry, _full(b"esds", stream))


def _box(kind: bytes, *parts: bytes) -> bytes:
    content = b"".join(parts)
    return struct.pack(">I4s", 8 + len(content), kind) + content


def _full(kind: bytes, *parts: bytes, flags: int = 0) -> bytes:
    """Build a full box: version 0 and flags before the content."""
    return _box(kind, struct.pack(">I", flags), *parts)


def _descriptor(tag: int, *parts: bytes) -> bytes:
    content = b"".join(parts)
    return struct.pack(">2B", tag, len(content)) + content
