"""Surface areas of the round lights, under any scale along their axes."""

from __future__ import annotations

import numpy as np


def ellipse_perimeter(a, b):
    """Ramanujan's first approximation, exact for circles; numbers or arrays."""
    return np.pi * (3.0 * (a + b) - np.sqrt((3.0 * a + b) * (a + 3.0 * b)))


def ellipsoid_area(a, b, c):
    """Thomsen's approximation, exact for spheres, within 1.1 % otherwise; numbers or arrays."""
    p = 1.6075
    return 4.0 * np.pi * (((a * b) ** p + (a * c) ** p + (b * c) ** p) / 3.0) ** (1.0 / p)
