"""Colors of depth: red is near, blue is far, on a logarithmic scale."""

from functools import lru_cache

import numpy as np

# Samples of the reversed Turbo colormap.
_DEPTH_COLORS = (
    (122, 4, 3), (183, 29, 2), (224, 73, 12), (246, 117, 26), (254, 163, 49), (235, 207, 53), (199, 239, 52),
    (147, 254, 77), (78, 248, 122), (30, 229, 181), (40, 188, 235), (70, 134, 251), (65, 69, 171), (48, 18, 59),
)  # fmt: skip


def depth_colors(values: np.ndarray) -> tuple[np.ndarray, tuple[float, float]]:
    """Return colors of distances, uint8 (H, W, 3), black where nothing is hit, and the ends of the scale.

    The ends are the 1st and 99th percentile, so that a few far pixels do not compress the scale.
    """
    values = np.asarray(values, np.float32).reshape(values.shape[:2])
    hit = np.isfinite(values) & (values > 0)
    near, far = (float(part) for part in np.percentile(values[hit], (1, 99))) if hit.any() else (0.0, 0.0)
    fraction = np.zeros(values.shape, np.float32)
    if far > near:
        fraction[hit] = np.log(np.clip(values[hit], near, far) / near) / np.log(far / near)
    colored = _table()[(fraction * 255).astype(np.uint8)]
    colored[~hit] = 0
    return colored, (near, far)


@lru_cache(maxsize=1)
def _table() -> np.ndarray:
    """Return the colors (256, 3) from near to far."""
    anchors = np.linspace(0, 255, len(_DEPTH_COLORS))
    columns = [np.interp(np.arange(256), anchors, channel) for channel in zip(*_DEPTH_COLORS)]
    return np.stack(columns, axis=1).astype(np.uint8)
