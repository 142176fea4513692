"""Anti-aliased lines and discs on an image."""

from collections.abc import Callable

import numpy as np

Color = tuple[int, int, int]

# Columns per window: a diagonal line covers few pixels of its bounding box, so it is drawn strip by strip.
_STRIP = 48


class Canvas:
    """An image to draw on. Positions are in pixels from the top left corner; pixel centers are at .5."""

    def __init__(self, image: np.ndarray) -> None:
        """image: uint8 (H, W, 3 or 4); it is copied."""
        self._image = image.copy()
        self.height, self.width = image.shape[:2]

    def image(self) -> np.ndarray:
        """Return the image, in the shape of the input."""
        return self._image

    def line(self, start: np.ndarray, end: np.ndarray, color: Color, *, width: float, opacity: float = 1.0) -> None:
        """Draw a line segment with round caps, clipped to the image."""
        reach = width / 2 + 1
        clipped = clip_to_rectangle(np.stack([start, end]), -reach, -reach, self.width + reach, self.height + reach)
        if clipped is None:
            return
        steep = abs(clipped[1, 1] - clipped[0, 1]) > abs(clipped[1, 0] - clipped[0, 0])
        major, minor, size = (1, 0, self.height) if steep else (0, 1, self.width)
        a, b = clipped if clipped[0, major] <= clipped[1, major] else clipped[::-1]
        first, last = int(max(a[major] - reach, 0)), int(min(b[major] + reach + 1, size))
        for left in range(first, last, _STRIP):
            right = min(left + _STRIP, last)
            # The extent of the line in this strip, by its slope; its round caps do not reach further.
            t = np.clip((np.array([left - reach, right + reach]) - a[major]) / max(b[major] - a[major], 1e-9), 0, 1)
            spread = a[minor] + t * (b[minor] - a[minor])
            low, high = int(spread.min() - reach), int(spread.max() + reach) + 1
            box = (left, low, right, high) if major == 0 else (low, left, high, right)
            self._blend(box, color, opacity, lambda x, y: width / 2 - _distance(x, y, a, b))

    def disc(self, center: np.ndarray, color: Color, *, radius: float, opacity: float = 1.0) -> None:
        """Draw a filled circle."""
        x, y = (float(np.clip(c, -1e6, 1e6)) for c in center)
        reach = radius + 1
        box = (int(x - reach), int(y - reach), int(x + reach) + 1, int(y + reach) + 1)
        self._blend(box, color, opacity, lambda px, py: radius - np.hypot(px - x, py - y))

    def _blend(
        self,
        box: tuple[int, int, int, int],
        color: Color,
        opacity: float,
        inside: Callable[[np.ndarray, np.ndarray], np.ndarray],
    ) -> None:
        """Paint where the signed distance `inside(x, y)` to the edge [pixels] is positive, anti-aliased at the edge."""
        left, top = max(box[0], 0), max(box[1], 0)
        right, bottom = min(box[2], self.width), min(box[3], self.height)
        if left >= right or top >= bottom:
            return
        x = np.arange(left, right, dtype=np.float32)[None, :] + 0.5
        y = np.arange(top, bottom, dtype=np.float32)[:, None] + 0.5
        alpha = (np.clip(inside(x, y) + 0.5, 0, 1) * opacity)[..., None]
        pixels = self._image[top:bottom, left:right, :3]
        pixels[...] = pixels + alpha * (np.array(color, np.float32) - pixels) + 0.5


def _distance(x: np.ndarray, y: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the distance of pixels to the segment from a to b."""
    along = b - a
    length = float(along @ along)
    t = 0.0 if length == 0 else np.clip(((x - a[0]) * along[0] + (y - a[1]) * along[1]) / length, 0, 1)
    return np.hypot(x - a[0] - t * along[0], y - a[1] - t * along[1])


def clip_to_rectangle(segment: np.ndarray, left: float, top: float, right: float, bottom: float) -> np.ndarray | None:
    """Return the part (2, 2) of a segment inside a rectangle, or None (Liang-Barsky clipping)."""
    start, along = segment[0].astype(np.float64), (segment[1] - segment[0]).astype(np.float64)
    enter, leave = 0.0, 1.0
    for axis, low, high in ((0, left, right), (1, top, bottom)):
        if abs(along[axis]) < 1e-9:
            if not low <= start[axis] <= high:
                return None
            continue
        first, second = sorted(((low - start[axis]) / along[axis], (high - start[axis]) / along[axis]))
        enter, leave = max(enter, first), min(leave, second)
    return np.stack([start + enter * along, start + leave * along]) if enter <= leave else None
