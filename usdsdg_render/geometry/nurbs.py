"""Which part of a NURBS curve is drawn, by its order, its knots and its range."""

import numpy as np

from usdsdg import errors


def drawn_range(
    path: str, order: int, knots: np.ndarray, count: int, ranges: np.ndarray | None
) -> tuple[float, float] | None:
    """Return the first and the last parameter of a curve of `count` vertices; None, with a warning, where none is.

    ranges: (2,) as authored, which may leave out ends of the curve; None: all of it.
    """
    if order < 2:
        errors.warn_once(f"{path}: a curve of order {order} is not drawn. Correct order: 2 is linear, 4 cubic.")
        return None
    if count < order:
        errors.warn_once(
            f"{path}: a curve of order {order} with {errors.counted(count, 'vertex', 'vertices')} is not drawn, since "
            f"it needs {order}. Correct curveVertexCounts or order."
        )
        return None
    if not np.isfinite(knots).all() or (np.diff(knots) < 0.0).any() or knots[order - 1] >= knots[count]:
        errors.warn_once(
            f"{path}: a curve whose knots are {knots.tolist() if len(knots) <= 12 else 'no sequence of numbers'} is "
            f"not drawn. Author knots that do not decrease, and of which the first and the last of the curve differ."
        )
        return None
    low, high = float(knots[order - 1]), float(knots[count])
    if ranges is None:
        return low, high
    first, last = max(low, float(ranges[0])), min(high, float(ranges[1]))
    if np.isfinite(ranges).all() and first < last:
        return first, last
    errors.warn_once(
        f"{path}: ranges {tuple(ranges.tolist())} name no part of a curve whose knots go from {low:g} to {high:g}; all "
        f"of it is drawn. Correct ranges."
    )
    return low, high
