"""A picture that a notebook shows."""

from __future__ import annotations

import io
import os
from typing import Any

import numpy as np
from PIL import Image


class Picture:
    """An image that notebooks show, that saves itself, and that NumPy and Pillow read."""

    def __init__(self, pixels: np.ndarray) -> None:
        """pixels: uint8 (H, W, 3)."""
        self._pixels = np.ascontiguousarray(pixels[..., :3], np.uint8)

    @property
    def image(self) -> Image.Image:
        """The picture as an image of Pillow."""
        return Image.fromarray(self._pixels)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [pixels]."""
        return self._pixels.shape[1], self._pixels.shape[0]

    def thumbnail(self, longest: int) -> Picture:
        """Return the picture with at most that many pixels along its longer side."""
        image = self.image
        image.thumbnail((longest, longest), Image.Resampling.LANCZOS)
        return Picture(np.asarray(image))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write an image file, in the format that its ending names, such as .png or .jpg.

        Raises:
            ValueError: the ending names no format that Pillow writes.
            OSError: the file cannot be written.
        """
        self.image.save(path)

    def show(self) -> None:
        """Open the picture in the image viewer of the desktop."""
        self.image.show()

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        """Return uint8 (H, W, 3)."""
        found = self._pixels.astype(dtype, copy=False) if dtype is not None else self._pixels
        return found.copy() if copy or copy is None else found

    def _repr_png_(self) -> bytes:
        file = io.BytesIO()
        self.image.save(file, "PNG")
        return file.getvalue()

    def __repr__(self) -> str:
        return f"Picture({self.size[0]} x {self.size[1]})"
