"""Rigid motion between two states of a scene, so that a moving thing blurs instead of showing a row of copies."""

import numpy as np

# Largest deviation of the relative linear part from a rotation for which motion counts as rigid.
RIGID = 1e-4


def interpolate(before: np.ndarray, after: np.ndarray, fraction: float) -> np.ndarray:
    """Transforms at `fraction` of the way, 0 = `before`, 1 = `after`.

    Args:
        before, after: (N, 4, 4) float64 local-to-world, USD's row vectors.

    Returns:
        (N, 4, 4) float64. Origins move on straight lines; linear parts turn at constant rate about a fixed axis where
        the motion is rigid, and are blended entry by entry where it is not (a scale that changed).
    """
    if fraction >= 1.0:
        return after
    mixed = before + (after - before) * fraction
    turned = np.linalg.inv(_linear(before)) @ _linear(after)
    error = np.abs(turned @ turned.transpose(0, 2, 1) - np.eye(3)).max((1, 2))
    rigid = (error < RIGID) & (np.linalg.det(turned) > 0)
    if rigid.any():
        from scipy.spatial.transform import Rotation

        # A row-vector rotation is the transpose of the matrix that SciPy means.
        whole = Rotation.from_matrix(turned[rigid].transpose(0, 2, 1)).as_rotvec()
        part = Rotation.from_rotvec(whole * fraction).as_matrix().transpose(0, 2, 1)
        mixed[rigid, :3, :3] = before[rigid, :3, :3] @ part
    return mixed


def _linear(matrices: np.ndarray) -> np.ndarray:
    """The 3x3 part, with the identity where it cannot be inverted."""
    linear = matrices[:, :3, :3].copy()
    flat = ~np.isfinite(linear).all((1, 2)) | (np.abs(np.linalg.det(np.nan_to_num(linear))) < 1e-30)
    linear[flat] = np.eye(3)
    return linear
