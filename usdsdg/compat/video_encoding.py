"""`video_encoding`: videos from images, as Motion JPEG in MP4."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from usdsdg.errors import WriterError
from usdsdg.image_files.motion_jpeg import Video, encode_frame
from usdsdg.session.session import current
from usdsdg.stores.whole_file import write_whole


class VideoEncodingInterface:
    """One video at a time: frames are collected, and the file is written at the end."""

    def __init__(self) -> None:
        self._path: Path | None = None
        self._rate = 24.0
        self._size: tuple[int, int] | None = None
        self._video: Video | None = None

    def start_encoding(
        self, video_filename: str, framerate: float = 24.0, nframes: int = 0, overwrite_video: bool = True
    ) -> bool:
        """Begin a video; return False if the file exists and is not to be overwritten.

        `nframes`, the expected number of frames, is not needed.

        Raises:
            WriterError: another video has not been finished, or the frame rate is not positive.
        """
        if self._path is not None:
            raise WriterError(f"video_encoding: {self._path} has not been finished; call finalize_encoding() first")
        if framerate <= 0:
            raise WriterError(f"video_encoding: the frame rate is {framerate}; expected frames per second above 0")
        path = Path(video_filename)
        if path.exists() and not overwrite_video:
            return False
        self._path, self._rate, self._size, self._video = path, float(framerate), None, None
        return True

    def encode_next_frame_from_file(self, frame_filename: str) -> None:
        """Add the image in a file; files that writers have scheduled are waited for.

        Raises:
            WriterError: no video has begun, or the image has another size than the first.
        """
        from PIL import Image

        current().io_queue.wait_until_done()
        with Image.open(frame_filename) as image:
            self._add(np.asarray(image.convert("RGB")))

    def encode_next_frame_from_buffer(self, buffer_rgba8: object, width: int = 0, height: int = 0) -> None:
        """Add an image of 8-bit RGBA: an array (H, W, 4), or bytes with a width and height.

        Raises:
            WriterError: no video has begun, or the image has another size than the first.
        """
        if isinstance(buffer_rgba8, (bytes, bytearray, memoryview)):
            pixels = np.frombuffer(buffer_rgba8, np.uint8)
        else:
            pixels = np.asarray(buffer_rgba8, np.uint8)
        if pixels.ndim != 3:
            if not width or not height:
                raise WriterError("video_encoding: give width and height with a flat buffer")
            pixels = pixels.reshape(height, width, -1)
        self._add(pixels)

    def finalize_encoding(self) -> None:
        """Write the file.

        Raises:
            WriterError: no video has begun, or it has no frames.
            OutputNotWritable: the file cannot be written.
        """
        path, self._path = self._begun(), None
        video, self._video = self._video or Video((0, 0), self._rate), None
        write_whole(path, video)

    def _add(self, image: np.ndarray) -> None:
        path, size = self._begun(), (image.shape[1], image.shape[0])
        self._size = self._size or size
        if size != self._size:
            raise WriterError(f"video_encoding: {path} has frames of {self._size} pixels; this one has {size}")
        self._video = self._video or Video(size, self._rate)
        self._video.append(encode_frame(image))

    def _begun(self) -> Path:
        if self._path is None:
            raise WriterError("video_encoding: no video has begun; call start_encoding() first")
        return self._path


_interface = VideoEncodingInterface()


def get_video_encoding_interface() -> VideoEncodingInterface:
    return _interface
