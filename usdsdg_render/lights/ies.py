"""IES photometric files (ANSI/IES LM-63, 1986 to 2019): intensity of a luminaire by direction [cd].

Only type C photometry is supported, which nearly all files use: vertical angles from nadir (0) to zenith (180),
horizontal angles about that axis. Files that hold part of a symmetric distribution are completed by mirroring.
"""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from usdsdg import errors

# Rows of a profile are a quarter of a degree apart, columns one degree; nearly all files use multiples of that.
ROWS, COLUMNS = 721, 360
_TYPE_C = 1
_NUMBERS_BEFORE_ANGLES = 13


class Photometry(NamedTuple):
    """Intensities of a type C file [cd], with all multipliers applied."""

    vertical: np.ndarray  # (V,) degrees from nadir, increasing
    horizontal: np.ndarray  # (H,) degrees, increasing
    candela: np.ndarray  # (H, V)


def parse(text: str, *, name: str) -> Photometry:
    """Parse the text of an IES file; `name` is for error messages.

    Raises:
        AssetUnreadable: not an IES file, it ends early, its angles do not increase, or its photometry is not of type C.
    """
    numbers = _numbers(text, name)
    multiplier, vertical_count, horizontal_count = numbers[2], int(numbers[3]), int(numbers[4])
    if int(numbers[5]) != _TYPE_C:
        raise errors.AssetUnreadable(f"{name}: photometric type {int(numbers[5])}; only type C (1) is read")
    multiplier *= numbers[10] * numbers[11]
    ends = np.cumsum([_NUMBERS_BEFORE_ANGLES, vertical_count, horizontal_count, vertical_count * horizontal_count])
    if vertical_count < 2 or horizontal_count < 1 or len(numbers) < ends[-1]:
        raise errors.AssetUnreadable(
            f"{name}: {vertical_count} x {horizontal_count} angles ask for {ends[-1]} numbers, {len(numbers)} are there"
        )
    vertical, horizontal, candela = (numbers[a:b] for a, b in pairwise(ends))
    if (np.diff(vertical) <= 0).any() or (np.diff(horizontal) <= 0).any():
        raise errors.AssetUnreadable(f"{name}: angles do not rise")
    candela = np.maximum(candela.reshape(horizontal_count, vertical_count) * multiplier, 0.0)
    return Photometry(vertical, horizontal, candela)


def _numbers(text: str, name: str) -> np.ndarray:
    """Return all numbers after the TILT line and its data."""
    lines = text.splitlines()
    tilt = next((k for k, line in enumerate(lines) if line.strip().upper().startswith("TILT=")), None)
    if tilt is None:
        raise errors.AssetUnreadable(f"{name}: no IES file, it has no TILT line")
    words = " ".join(lines[tilt + 1 :]).replace(",", " ").split()
    try:
        numbers = np.array(words, np.float64)
    except ValueError as error:
        raise errors.AssetUnreadable(f"{name}: {error}") from error
    if lines[tilt].strip().upper() == "TILT=INCLUDE" and len(numbers) > 1:
        # Skip lamp geometry, count, angles and factors: dimming of tilted luminaires is not modeled.
        numbers = numbers[2 + 2 * int(numbers[1]) :]
    if len(numbers) < _NUMBERS_BEFORE_ANGLES or not np.isfinite(numbers).all():
        raise errors.AssetUnreadable(f"{name}: it ends early, or has numbers that are none")
    return numbers


def candela_at(photometry: Photometry, vertical: np.ndarray, horizontal: np.ndarray) -> np.ndarray:
    """Interpolate intensity at (V,) vertical and (H,) horizontal angles [degrees].

    Returns:
        (V, H) candelas; 0 outside of the file's vertical range.
    """
    angles, values = _closed(photometry)
    along = np.stack([np.interp(vertical, photometry.vertical, row, left=0.0, right=0.0) for row in values], 1)
    folded = _folded(photometry.horizontal, np.asarray(horizontal, float) % 360.0)
    return np.stack([np.interp(folded, angles, row) for row in along])


def _closed(photometry: Photometry) -> tuple[np.ndarray, np.ndarray]:
    """Return horizontal angles and their rows, with the first repeated at +360 degrees if the file omits that."""
    angles, values = photometry.horizontal, photometry.candela
    if angles[-1] in (90.0, 180.0, 270.0, 360.0) or len(angles) == 1:
        return angles, values
    return np.append(angles, angles[0] + 360.0), np.concatenate([values, values[:1]])


def _folded(angles: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Fold angles in [0, 360) into the file's range by the symmetry that this range implies."""
    if angles[0] == 90.0 and angles[-1] == 270.0:
        return np.where((angle < 90.0) | (angle > 270.0), (180.0 - angle) % 360.0, angle)
    if angles[-1] == 90.0:
        angle = np.where(angle > 180.0, 360.0 - angle, angle)
        return np.where(angle > 90.0, 180.0 - angle, angle)
    if angles[-1] == 180.0:
        return np.where(angle > 180.0, 360.0 - angle, angle)
    return np.where(angle < angles[0], angle + 360.0, angle)


def power(photometry: Photometry) -> float:
    """Return UsdLux's normalization divisor: mean candelas over the sphere, or over the covered hemisphere."""
    theta = (np.arange(4 * ROWS) + 0.5) * (math.pi / (4 * ROWS))
    mean_round = candela_at(photometry, np.degrees(theta), np.arange(COLUMNS)).mean(1)
    mean = float((mean_round * np.sin(theta)).mean() * math.pi / 2.0)
    covers_half = photometry.vertical[-1] - photometry.vertical[0] <= 90.0 + math.degrees(0.1)
    return mean * (2.0 if covers_half else 1.0)


def profile(photometry: Photometry, *, angle_scale: float = 0.0, normalize: bool = False) -> np.ndarray:
    """Resample to the factors of `scene.EmissionProfile`: (ROWS, COLUMNS) float32, or (ROWS, 1) if axially symmetric.

    Args:
        angle_scale: inputs:shaping:ies:angleScale; 0 leaves the vertical angles, positive values stretch them about
            nadir, negative ones about zenith.
        normalize: divide by `power`.
    """
    vertical = np.arange(ROWS) * (180.0 / (ROWS - 1))
    if angle_scale > 0.0:
        vertical = vertical / angle_scale
    elif angle_scale < 0.0:
        vertical = (vertical - 180.0) / -angle_scale + 180.0
    columns = 1 if len(photometry.horizontal) == 1 else COLUMNS
    horizontal = np.arange(columns) * (360.0 / columns)
    factors = candela_at(photometry, np.clip(vertical, 0.0, 180.0), horizontal)
    total = power(photometry) if normalize else 1.0
    return (factors / total if total > 0.0 else factors).astype(np.float32)
