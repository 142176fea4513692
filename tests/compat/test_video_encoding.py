"""`video_encoding` writes the frames that it is given."""

import io

import numpy as np
import pytest
from PIL import Image

from usdsdg.compat.video_encoding import VideoEncodingInterface
from usdsdg.errors import WriterError


def frames_of(file):
    """Cut the JPEG images out of a Motion JPEG file."""
    data = file.read_bytes()
    starts = [k for k in range(len(data) - 2) if data[k : k + 3] == b"\xff\xd8\xff"]
    return [np.asarray(Image.open(io.BytesIO(data[start:]))) for start in starts]


def test_frames_come_from_files_and_buffers(tmp_path):
    video = VideoEncodingInterface()
    assert video.start_encoding(str(tmp_path / "a.mp4"), 24.0, 2, True)
    Image.new("RGB", (16, 8), (200, 0, 0)).save(tmp_path / "red.png")
    video.encode_next_frame_from_file(str(tmp_path / "red.png"))
    video.encode_next_frame_from_buffer(bytes([0, 0, 200, 255] * 128), width=16, height=8)
    video.finalize_encoding()
    red, blue = (frame.astype(int) for frame in frames_of(tmp_path / "a.mp4"))
    assert red.shape == (8, 16, 3)
    assert red[4, 8] == pytest.approx([200, 0, 0], abs=3)
    assert blue[4, 8] == pytest.approx([0, 0, 200], abs=3)


def test_a_file_is_overwritten_only_if_asked_to(tmp_path):
    (tmp_path / "a.mp4").write_bytes(b"old")
    assert not VideoEncodingInterface().start_encoding(str(tmp_path / "a.mp4"), 24.0, 0, False)


def test_frames_have_one_size_and_a_video(tmp_path):
    video = VideoEncodingInterface()
    with pytest.raises(WriterError, match="start_encoding"):
        video.encode_next_frame_from_buffer(np.zeros((4, 4, 4), np.uint8))
    video.start_encoding(str(tmp_path / "a.mp4"))
    video.encode_next_frame_from_buffer(np.zeros((4, 4, 4), np.uint8))
    with pytest.raises(WriterError, match=r"\(4, 4\)"):
        video.encode_next_frame_from_buffer(np.zeros((8, 4, 4), np.uint8))
