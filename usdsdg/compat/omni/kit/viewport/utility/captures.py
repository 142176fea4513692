"""Single pictures of a viewport, in a file or a buffer; they show the stage as it is when they are asked for."""

from __future__ import annotations

import ctypes
import enum
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.app.app import get_app
from usdsdg.errors import Unsupported
from usdsdg.session.session import current
from usdsdg.writers.files import write_image


class View(Protocol):
    """What is captured: a viewport."""

    @property
    def render_product_path(self) -> str: ...


class TextureFormat(enum.Enum):
    """How the numbers of a buffer are stored."""

    RGBA8_UNORM = 0

    def __str__(self) -> str:
        return f"TextureFormat.{self.name}"


class Capture:
    """A capture, which is done."""

    async def wait_for_result(self, completion_frames: int = 2) -> bool:
        """Wait for updates of the application, as a capture in its viewport takes; return True."""
        for _ in range(completion_frames):
            await get_app().next_update_async()
        return True


def color_of(viewport: View) -> np.ndarray:
    """Return what a viewport sees, uint8 (H, W, 4)."""
    annotator = named_annotators.get("rgb").attach(viewport.render_product_path)
    try:
        current().live.show(annotator)
        return np.array(annotator.get_data(device="cpu"))
    finally:
        annotator.detach()


def capture_viewport_to_file(
    viewport: View, file_path: str, is_hdr: bool = False, render_product_path: str | None = None, **_: object
) -> Capture:
    """Write what a viewport sees, as it is now; the extension of the path says the format.

    Raises:
        Unsupported: `is_hdr`, or another render product than the viewport's.
        WriterError: there is no format of this extension.
    """
    _refuse("capture_viewport_to_file", is_hdr, render_product_path)
    Path(file_path).resolve().parent.mkdir(parents=True, exist_ok=True)
    write_image(str(file_path), color_of(viewport))
    return Capture()


def capture_viewport_to_buffer(
    viewport: View,
    on_capture_fn: Callable[..., Any],
    is_hdr: bool = False,
    render_product_path: str | None = None,
    **_: object,
) -> Capture:
    """Call `on_capture_fn(buffer, bytes, width, height, format)` with what a viewport sees, as it is now.

    buffer: a PyCapsule without a name, of RGBA with one byte each, that is valid during the call.

    Raises:
        Unsupported: `is_hdr`, or another render product than the viewport's.
    """
    _refuse("capture_viewport_to_buffer", is_hdr, render_product_path)
    image = np.ascontiguousarray(color_of(viewport))
    make = ctypes.pythonapi.PyCapsule_New
    make.restype, make.argtypes = ctypes.py_object, [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]
    height, width = image.shape[:2]
    on_capture_fn(make(image.ctypes.data, None, None), image.nbytes, width, height, TextureFormat.RGBA8_UNORM)
    return Capture()


def _refuse(caller: str, is_hdr: bool, render_product_path: str | None) -> None:
    if is_hdr:
        raise Unsupported(f"{caller}: is_hdr is not available; attach the annotator HdrColor to a render product")
    if render_product_path is not None:
        raise Unsupported(f"{caller}: set viewport.render_product_path = {render_product_path!r} first")
