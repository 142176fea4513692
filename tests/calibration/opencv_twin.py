"""OpenCV's projections from its documented formulas, slowly and in plain NumPy."""

import numpy as np


def projected(points, matrix, distortion, *, fisheye: bool) -> np.ndarray:
    """Return pixels (N, 2), 0 at the center of the first, of points (N, 3) with x right, y down, z ahead."""
    x, y = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
    r2 = x * x + y * y
    d = np.zeros(12)
    d[: len(distortion)] = distortion
    if fisheye:
        r = np.sqrt(r2)
        theta = np.arctan(r)
        bent = theta * (1 + d[0] * theta**2 + d[1] * theta**4 + d[2] * theta**6 + d[3] * theta**8)
        x, y = x * bent / r, y * bent / r
    else:
        k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = d
        radial = (1 + k1 * r2 + k2 * r2**2 + k3 * r2**3) / (1 + k4 * r2 + k5 * r2**2 + k6 * r2**3)
        x, y = (
            x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x) + s1 * r2 + s2 * r2**2,
            y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y + s3 * r2 + s4 * r2**2,
        )
    return np.stack([matrix[0][0] * x + matrix[0][2], matrix[1][1] * y + matrix[1][2]], axis=1)
