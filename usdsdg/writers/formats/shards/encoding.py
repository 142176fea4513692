"""Encoding of arrays to the bytes of files, which shards contain."""

from __future__ import annotations

from typing import Any

from usdsdg.writers.files import write_image, write_np


class _Kept:
    """A sink of one file's bytes."""

    data = b""

    def write_blob(self, path: str, data: bytes) -> None:
        self.data = data


def image_bytes(image: Any, extension: str) -> bytes:
    """Return an image as a file of the format of an extension; errors are those of `write_image`."""
    kept = _Kept()
    write_image(f"image.{extension}", image, kept)
    return kept.data


def array_bytes(array: Any) -> bytes:
    """Return an array as a .npy file."""
    kept = _Kept()
    write_np("array.npy", array, kept)
    return kept.data
