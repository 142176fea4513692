"""Augmentations that filter neighborhoods: convolution, motion blur, pixelation, edges.

Images are uint8 (H, W, 3 or 4); alpha does not change. Borders are extended by their edge pixels.
"""

from typing import Any

import numpy as np

from usdsdg.annotators.augmentations.colors import gray, to_bytes, with_rgb
from usdsdg.annotators.augmentations.signatures import kernel_in_replicator
from usdsdg.graph.sampling import generator

# Replicator's Canny compares three times the gradient with its thresholds.
CANNY_SCALE = 3.0


def conv2d(
    data_in: np.ndarray, kernel: Any = None, alpha: float = 0.7, kernelWidth: int = 3, seed: int = 0
) -> np.ndarray:
    """Convolve, and blend the result with the input: alpha * filtered + (1 - alpha) * input.

    Args:
        data_in: the image.
        kernel: weights (N, N), or flat (N * N); N is odd. Not mirrored: row 0 weights the row above. None draws
            `kernelWidth` x `kernelWidth` weights by He initialization, as older versions do.
        alpha: 0 is the input, 1 the filtered image.
        kernelWidth: size of a drawn kernel.
        seed: of a drawn kernel.

    Raises:
        ValueError: the kernel is not square, or its size is even.
    """
    if kernel is None or np.size(kernel) == 0:
        size = int(kernelWidth)
        weights = generator(seed, "conv2d", 0).normal(0, np.sqrt(2 / size**2), (size, size))
    else:
        weights = _square(kernel)
    return _filtered(data_in, weights, alpha)


def motion_blur(
    data_in: np.ndarray,
    motionAngle: float | None = None,
    strength: float | None = None,
    kernelSize: int = 11,
    alpha: float = 0.7,
    seed: int = 0,
) -> np.ndarray:
    """Blur along a line, and blend the result with the input: alpha * blurred + (1 - alpha) * input.

    Args:
        data_in: the image.
        motionAngle: degrees; 0 to the left, 90 to the bottom, 270 to the top. None draws one.
        strength: from -1, most weight behind, over 0, equal weights, to 1, most weight ahead. None draws one.
        kernelSize: length of the line [pixels]; at least 2.
        alpha: 0 is the input, 1 the blurred image.
        seed: of the random draws.
    """
    draws = generator(seed, "motion_blur", 0).random(2)
    angle = 360 * draws[0] if motionAngle is None else motionAngle
    lean = 2 * draws[1] - 1 if strength is None else strength
    return _filtered(data_in, _motion_weights(int(kernelSize), float(angle), float(lean)), alpha)


def pixellate(data_in: np.ndarray, kernelSize: int = 8) -> np.ndarray:
    """Fill each block of `kernelSize` x `kernelSize` pixels with its mean color; right and bottom blocks may be cut.

    Raises:
        ValueError: kernelSize is below 1.
    """
    size = int(kernelSize)
    if size < 1:
        raise ValueError(f"kernelSize is {kernelSize!r}; expected a whole number above 0")
    sums, counts = data_in[..., :3].astype(np.float64), np.ones(data_in.shape[:2])
    for axis in (0, 1):
        starts = np.arange(0, data_in.shape[axis], size)
        sums, counts = np.add.reduceat(sums, starts, axis), np.add.reduceat(counts, starts, axis)
    means = to_bytes(sums / counts[..., None])
    rows, columns = (np.arange(length) // size for length in data_in.shape[:2])
    return with_rgb(data_in, means[rows][:, columns])


@kernel_in_replicator
def sobel(data_in: np.ndarray) -> np.ndarray:
    """Return edge strength, uint8 (H, W, 4): a quarter of the gradient of the channels' mean; black at the border."""
    dx, dy = _gradient(data_in[..., :3].astype(np.float32).mean(axis=-1))
    edges = to_bytes(np.hypot(dx, dy) / 4)
    return np.dstack([edges, edges, edges, np.full_like(edges, 255)])


def canny(data_in: np.ndarray, thresholdLow: float = 50.0, thresholdHigh: float = 100.0) -> np.ndarray:
    """Return Canny edges, uint8 (H, W): 255 on edges, 0 elsewhere and at the border.

    An edge is where three times the Sobel gradient of the blurred luma is largest across the edge and above
    `thresholdHigh`, or above `thresholdLow` and connected to such pixels.
    """
    from scipy import ndimage

    shades = gray(data_in)
    smooth = shades.astype(np.float32)
    blurred = ndimage.correlate(smooth, np.outer([1, 2, 1], [1, 2, 1]) / np.float32(16), mode="nearest")
    smooth[1:-1, 1:-1] = to_bytes(blurred)[1:-1, 1:-1]
    dx, dy = _gradient(smooth)
    strength = np.hypot(dx, dy)
    # Direction across the edge, quantized to four.
    octant = np.round(np.arctan2(dy, dx) / (np.pi / 4)).astype(int) % 4
    padded = np.pad(strength, 1)
    height, width = strength.shape
    ahead, behind = np.zeros_like(strength), np.zeros_like(strength)
    for number, (down, right) in enumerate([(0, 1), (1, 1), (1, 0), (1, -1)]):
        here = octant == number
        ahead[here] = padded[1 + down : 1 + down + height, 1 + right : 1 + right + width][here]
        behind[here] = padded[1 - down : 1 - down + height, 1 - right : 1 - right + width][here]
    # Of two equal pixels across a ridge one is kept.
    ridge = np.where((strength > ahead) & (strength >= behind), strength * CANNY_SCALE, 0)
    marked = (ridge >= thresholdLow) & (ridge > 0)
    # SciPy has no types: `label` returns a pair unless it is given an output array.
    components, _ = ndimage.label(marked, np.ones((3, 3)))  # pyright: ignore[reportGeneralTypeIssues]
    strong = np.unique(components[(ridge >= thresholdHigh) & (ridge > 0)])
    return np.where(np.isin(components, strong[strong > 0]), np.uint8(255), np.uint8(0))


def _filtered(image: np.ndarray, weights: np.ndarray, alpha: float) -> np.ndarray:
    from scipy import ndimage

    colors = image[..., :3].astype(np.float32)
    channels = [ndimage.correlate(colors[..., c], weights.astype(np.float32), mode="nearest") for c in range(3)]
    filtered = np.clip(np.stack(channels, axis=-1), 0, 255)
    # Weights that should sum to 1 miss it by rounding; the offset keeps a constant image unchanged.
    return with_rgb(image, to_bytes(alpha * filtered + (1 - alpha) * colors + np.float32(1e-3)))


def _square(kernel: Any) -> np.ndarray:
    weights = np.asarray(kernel, np.float64)
    size = round(weights.size**0.5)
    if size * size != weights.size or (weights.ndim > 1 and weights.shape != (size, size)):
        raise ValueError(f"kernel of shape {weights.shape} is not square")
    if size % 2 == 0:
        raise ValueError(f"kernel of {size} x {size} has no middle; its size has to be odd")
    return weights.reshape(size, size)


def _motion_weights(size: int, angle: float, strength: float) -> np.ndarray:
    """Return weights (N, N) along the line through the center, varying linearly between its ends, with sum 1."""
    if size < 2:
        raise ValueError(f"kernelSize is {size!r}; expected a whole number above 1")
    half = size // 2
    rows, columns = np.mgrid[-half : half + 1, -half : half + 1]
    radians = np.deg2rad(angle)
    # Coordinates along and across the line; its first end is at the left for 0 degrees and at the bottom for 90.
    along = columns * np.cos(radians) - rows * np.sin(radians)
    across = columns * np.sin(radians) + rows * np.cos(radians)
    on_line = (np.abs(across) < 0.5 + 1e-9) & (np.abs(along) <= half + 1e-9)
    ahead = (np.clip(strength, -1, 1) + 1) / 2
    fraction = np.clip((along + half) / (2 * half), 0, 1)
    weights = np.where(on_line, ahead + (1 - 2 * ahead) * fraction, 0)
    return weights / weights.sum()


def _gradient(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return Sobel's derivatives to the right and downward, 0 at the border."""
    dx, dy = np.zeros_like(values), np.zeros_like(values)
    if min(values.shape) > 2:
        down = values[:-2] + 2 * values[1:-1] + values[2:]
        dx[1:-1, 1:-1] = down[:, 2:] - down[:, :-2]
        right = values[:, :-2] + 2 * values[:, 1:-1] + values[:, 2:]
        dy[1:-1, 1:-1] = right[2:] - right[:-2]
    return dx, dy
