"""Anti-aliased lines and discs on an image."""

from typing import Any

import numpy as np

from usdsdg.warp_start import loaded_on_cpu

Color = tuple[int, int, int]


class Canvas:
    """An image to draw on. Positions are in pixels from the top left corner; pixel centers are at .5."""

    def __init__(self, image: np.ndarray) -> None:
        """image: uint8 (H, W, 3 or 4)."""
        self._image = image
        self._strokes: list[tuple[float, ...]] = []
        self.height, self.width = image.shape[:2]

    def image(self) -> np.ndarray:
        """Return a copy of the image with all that was drawn, each over what was drawn before it."""
        import warp as wp

        image = np.array(self._image, np.uint8, order="C")
        if self._strokes and image.size:
            strokes = wp.array(np.array(self._strokes, np.float64), dtype=wp.float64, device="cpu", copy=False)
            pixels = wp.array(image, dtype=wp.uint8, device="cpu", copy=False)
            wp.launch(load(), dim=self.height, inputs=[strokes, pixels], device="cpu")
        return image

    def line(self, start: np.ndarray, end: np.ndarray, color: Color, *, width: float, opacity: float = 1.0) -> None:
        """Draw a line segment with round caps."""
        self._strokes.append((*start, *end, width / 2, opacity, *color))

    def disc(self, center: np.ndarray, color: Color, *, radius: float, opacity: float = 1.0) -> None:
        """Draw a filled circle."""
        self._strokes.append((*center, *center, radius, opacity, *color))


def load() -> Any:
    """Return the kernel, loaded; see `loaded_on_cpu`."""
    return loaded_on_cpu(_kernel)


def _kernel() -> Any:
    from usdsdg.writers.formats.shapes.stroke_kernels import draw_strokes

    return draw_strokes
