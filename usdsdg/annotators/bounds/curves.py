"""Places along curves, between which they do not leave the hull: what bounds a curve, which its vertices do not."""

import numpy as np
from pxr import Usd, UsdGeom

# Up to so many segments in a prim are sampled; of more, the Bezier control points are taken, whose hull is larger.
_MOST_SAMPLED = 5_000
_SAMPLES = 33  # of a segment: between two of them it strays by a thousandth of its own bend

# Bezier control points of a segment, of its four vertices.
_TO_BEZIER = {
    "bezier": np.eye(4),
    "bspline": np.array([[1, 4, 1, 0], [0, 4, 2, 0], [0, 2, 4, 0], [0, 1, 4, 1]]) / 6.0,
    "catmullRom": np.array([[0, 6, 0, 0], [-1, 6, 1, 0], [0, 1, 6, -1], [0, 0, 6, 0]]) / 6.0,
}


def along_curves(prim: Usd.Prim, time: Usd.TimeCode, values: np.ndarray) -> np.ndarray:
    """Return values (N, D) along curves, interpolated as positions are, of those at their vertices (V, D).

    Beside the position, values of Hermite curves are interpolated linearly, as they are drawn. Those of curves that are
    linear, of NURBS and of what cannot be drawn are the values at the vertices.
    """
    counts = np.maximum(np.asarray(UsdGeom.Curves(prim).GetCurveVertexCountsAttr().Get(time) or (), np.int64), 0)
    if not len(counts) or counts.sum() > len(values):
        return values
    tangents = _tangents(prim, time, values)
    basis, wrap = _basis_and_wrap(prim, time)
    if tangents is None and basis not in _TO_BEZIER:
        return values
    starts, found = np.cumsum(counts) - counts, []
    for count in np.unique(counts):
        vertices = starts[counts == count, None] + np.arange(count)
        if tangents is not None:
            found.append(_hermite(values[vertices], tangents[vertices]))
        else:
            found.append(_TO_BEZIER[basis] @ _segments(values[vertices], basis, wrap))
    controls = np.concatenate(found)  # (segments, 4, D)
    if not len(controls):
        return values
    return (_bernstein() @ controls if len(controls) <= _MOST_SAMPLED else controls).reshape(-1, values.shape[1])


def _basis_and_wrap(prim: Usd.Prim, time: Usd.TimeCode) -> tuple[str, str]:
    curves = UsdGeom.BasisCurves(prim)
    if not curves or curves.GetTypeAttr().Get(time) == UsdGeom.Tokens.linear:
        return "", ""
    return str(curves.GetBasisAttr().Get(time)), str(curves.GetWrapAttr().Get(time))


def _tangents(prim: Usd.Prim, time: Usd.TimeCode, values: np.ndarray) -> np.ndarray | None:
    """Return the tangents (V, 3) of Hermite curves."""
    tangents = UsdGeom.HermiteCurves(prim).GetTangentsAttr().Get(time) if prim.IsA(UsdGeom.HermiteCurves) else None
    if tangents is None or len(tangents) < len(values):
        return None
    return np.asarray(tangents, np.float64)[: len(values)]


def _segments(values: np.ndarray, basis: str, wrap: str) -> np.ndarray:
    """Return the vertices of all segments (S, 4, D) of curves (C, V, D) with equally many vertices."""
    if wrap == "pinned" and basis != "bezier":
        first, last = 2 * values[:, :1] - values[:, 1:2], 2 * values[:, -1:] - values[:, -2:-1]
        values = np.concatenate([first, values, last], axis=1)
    step, count = 3 if basis == "bezier" else 1, values.shape[1]
    segments = count // step if wrap == "periodic" else (count - 4) // step + 1 if count >= 4 else 0
    if count < 3:
        segments = 0
    vertices = (np.arange(segments)[:, None] * step + np.arange(4)) % max(count, 1)
    return values[:, vertices].reshape(-1, 4, values.shape[2])


def _hermite(values: np.ndarray, tangents: np.ndarray) -> np.ndarray:
    """Return Bezier control points (S, 4, D) of Hermite curves (C, V, D)."""
    before, after = values[:, :-1], values[:, 1:]
    along = [after - before, after - before]
    for each, ends in zip(along, (tangents[:, :-1], tangents[:, 1:])):
        each[..., :3] = ends
    inner = before + along[0] / 3, after - along[1] / 3
    return np.stack([before, *inner, after], axis=2).reshape(-1, 4, values.shape[2])


def _bernstein() -> np.ndarray:
    """Return the weights (K, 4) of Bezier control points at K parameters."""
    t = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    return np.concatenate([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3], axis=1)
