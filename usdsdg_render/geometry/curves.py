"""UsdGeom curves as polylines: where each curve runs, and how thick it is there.

BasisCurves are evaluated with their basis, HermiteCurves with their tangents and NurbsCurves with their knots and
weights: exactly, at some parameters of each segment.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from pxr import Usd, UsdGeom
from scipy.interpolate import BSpline

from usdsdg import errors
from usdsdg_render.geometry.mesh_source import Primvar, read_array, read_primvar

# Rows: powers 1, t, t2, t3 of the parameter; columns: the four vertices of a segment.
BASES = {
    "bezier": np.array([[1, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1]], float),
    "bspline": np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]]) / 6.0,
    "catmullRom": np.array([[0, 2, 0, 0], [-1, 0, 1, 0], [2, -5, 4, -1], [-1, 3, -3, 1]]) / 2.0,
}
DEFAULT_WIDTH = 1.0  # of what has none [stage units], as Hydra draws it


class Lines(NamedTuple):
    """Curves of equally many samples."""

    points: np.ndarray  # (C, K, 3) float64
    radii: np.ndarray  # (C, K) float64
    closed: bool  # the last sample joins the first
    curves: np.ndarray  # (C,) which curve of the prim


class _Curves(NamedTuple):
    """The attributes that all curves have."""

    points: np.ndarray
    counts: np.ndarray
    widths: Primvar


def read_lines(prim: Usd.Prim, time: Usd.TimeCode, points: np.ndarray | None, steps: int) -> list[Lines]:
    """The curves of a prim in groups of equal length; empty (with a warning) where there is nothing to draw.

    Args:
        points: what stands for its points, where a skeleton moved them.
        steps: samples of each segment.
    """
    curves = _read(prim, time, points)
    if curves is None:
        return []
    reader = {"BasisCurves": _basis_lines, "HermiteCurves": _hermite_lines, "NurbsCurves": _nurbs_lines}
    starts = np.cumsum(curves.counts) - curves.counts
    lines = []
    for count in np.unique(curves.counts):
        which = np.flatnonzero(curves.counts == count)
        where = starts[which, None] + np.arange(count)
        lines += reader[str(prim.GetTypeName())](prim, time, curves, which, where, steps)
    kept = [_whole(each) for each in lines]
    lost = sum(len(each.points) for each in lines) - sum(len(each.points) for each in kept)
    if lost:
        errors.warn_once(
            f"{prim.GetPath()}: {lost} curves have points or widths that are NaN or infinite, or no width > 0, and are "
            f"not drawn. Correct them."
        )
    return [each for each in kept if len(each.points)]


def count_segments(prim: Usd.Prim, time: Usd.TimeCode) -> int:
    """About how many segments the curves of a prim have, for choosing how fine to draw them."""
    counts = read_array(prim, "curveVertexCounts", time, ())
    return 0 if counts is None else int(np.maximum(counts, 0).sum())


def _read(prim: Usd.Prim, time: Usd.TimeCode, points: np.ndarray | None) -> _Curves | None:
    points = read_array(prim, "points", time, (3,)) if points is None else points
    counts = read_array(prim, "curveVertexCounts", time, ())
    if points is None or counts is None or not len(points) or not len(counts):
        errors.warn_once(
            f"{prim.GetPath()}: there are no curves (no points or no curveVertexCounts), so nothing is drawn. Author "
            f"them, or remove the prim."
        )
        return None
    if (counts < 0).any() or counts.sum() > len(points):
        errors.warn_once(
            f"{prim.GetPath()}: curveVertexCounts sum to {int(counts.sum())} but there are {len(points)} points, so "
            f"the curves are not drawn. Correct them."
        )
        return None
    if read_array(prim, "normals", time, (3,)) is not None:
        errors.warn_once(f"{prim.GetPath()}: curves with normals are drawn as round tubes, not as ribbons.")
    return _Curves(np.asarray(points, np.float64), counts.astype(np.int64), read_widths(prim, time))


def read_widths(prim: Usd.Prim, time: Usd.TimeCode) -> Primvar:
    """Diameters of curves or points. `primvars:widths` wins over `widths`, which are of vertices unless they say."""
    primvar = read_primvar(prim, "primvars:widths", time, ())
    if primvar is not None:
        return primvar
    values = read_array(prim, "widths", time, ())
    if values is None or not len(values):
        errors.warn_once(
            f"{prim.GetPath()}: it has no widths, so {DEFAULT_WIDTH} is used. Author widths [stage units]."
        )
        return Primvar(np.full(1, DEFAULT_WIDTH), np.zeros(0, np.int32), "constant")
    said = prim.GetAttribute("widths").GetMetadata("interpolation")
    return Primvar(values, np.zeros(0, np.int32), "constant" if len(values) == 1 else str(said or "vertex"))


def _whole(lines: Lines) -> Lines:
    """Those that can be drawn: a width of zero here and there is a tip."""
    good = np.isfinite(lines.points).all(axis=(1, 2)) & np.isfinite(lines.radii).all(axis=1)
    good &= (lines.radii > 0.0).any(axis=1)
    return Lines(lines.points[good], lines.radii[good], lines.closed, lines.curves[good])


def _too_short(prim: Usd.Prim, count: int, least: int) -> None:
    errors.warn_once(
        f"{prim.GetPath()}: curves of {count} vertices are not drawn, since theirs need {least} or more. Correct "
        f"curveVertexCounts."
    )


def _parameters(steps: int, segments: int, closed: bool) -> tuple[np.ndarray, np.ndarray]:
    """(K,) segment and (K,) parameter in it of each sample; an open curve ends with a sample at its last end."""
    segment = np.repeat(np.arange(segments), steps)
    t = np.tile(np.arange(steps) / steps, segments)
    if closed:
        return segment, t
    return np.append(segment, segments - 1), np.append(t, 1.0)


def _cubic(values: np.ndarray, basis: np.ndarray, vertices: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(C, K, n) of vertex values (C, V, n): sample k mixes `vertices[k]` (K, 4) at parameter t[k]."""
    weights = np.stack([t**0, t, t**2, t**3], axis=-1) @ basis
    return np.einsum("kv,ckvn->ckn", weights, values[:, vertices])


def _widths_at(
    prim: Usd.Prim, widths: Primvar, which: np.ndarray, where: np.ndarray, first_varying: np.ndarray, ends: int
) -> tuple[np.ndarray, str]:
    """((C, V or E or 1) widths, vertex, varying or constant)."""
    values = widths.values[widths.indices] if len(widths.indices) else widths.values
    rows = {
        "uniform": which[:, None],
        "vertex": where,
        "varying": first_varying[which, None] + np.arange(ends),
    }.get(widths.interpolation, np.zeros((len(which), 1), np.int64))
    if rows.size and rows.max() >= len(values):
        errors.warn_once(
            f"{prim.GetPath()}: the {widths.interpolation} widths have {len(values)} values, too few for the curves; "
            f"the first one is used. Author one per element or correct the interpolation."
        )
        rows = np.zeros((len(which), 1), np.int64)
    kind = widths.interpolation if rows.shape[1] > 1 else "constant"
    return np.asarray(values, np.float64)[rows], kind


# One kind of curve each


def _basis_lines(prim, time, curves: _Curves, which: np.ndarray, where: np.ndarray, steps: int) -> list[Lines]:
    schema = UsdGeom.BasisCurves(prim)
    linear = schema.GetTypeAttr().Get(time) == UsdGeom.Tokens.linear
    basis = "linear" if linear else _token(prim, "basis", time, tuple(BASES))
    wrap = _token(prim, "wrap", time, ("nonperiodic", "periodic", "pinned"))
    closed = wrap == "periodic"
    count = where.shape[1]
    least = 2 if linear or (wrap == "pinned" and basis != "bezier") else 3 if closed else 4
    if count < least:
        _too_short(prim, count, least)
        return []
    ends = _ends(basis, wrap, curves.counts)
    varying = np.cumsum(ends) - ends
    segments = int(ends[which[0]]) - (not closed)
    segment, t = _parameters(1 if linear else steps, segments, closed)
    widths, kind = _widths_at(prim, curves.widths, which, where, varying, int(ends[which[0]]))
    values = curves.points[where]
    if kind == "vertex":
        values = np.concatenate([values, widths[..., None]], axis=-1)
    if linear:
        samples = _linear(values, segment, t)
    else:
        if wrap == "pinned" and basis != "bezier":  # a vertex beyond each end, so that the curve reaches it
            first, last = 2 * values[:, :1] - values[:, 1:2], 2 * values[:, -1:] - values[:, -2:-1]
            values = np.concatenate([first, values, last], axis=1)
        step = 3 if basis == "bezier" else 1
        vertices = (segment[:, None] * step + np.arange(4)) % values.shape[1]
        samples = _cubic(values, BASES[basis], vertices, t)
    return [Lines(samples[..., :3], _radii(samples, widths, kind, segment, t) / 2.0, closed, which)]


def _token(prim: Usd.Prim, name: str, time: Usd.TimeCode, known: tuple[str, ...]) -> str:
    """A token of a prim, the first that is known (with a warning) for any other."""
    value = str(prim.GetAttribute(name).Get(time) or known[0])
    if value in known:
        return value
    errors.warn_once(
        f"{prim.GetPath()}: {name} {value!r} is none of {', '.join(known)}; {known[0]} is used. Correct it."
    )
    return known[0]


def _ends(basis: str, wrap: str, counts: np.ndarray) -> np.ndarray:
    """(C,) ends of segments of each curve, which have the varying values."""
    if wrap == "periodic":
        return counts // 3 if basis == "bezier" else counts
    if basis == "bezier":
        return np.maximum(counts - 1, 0) // 3 + 1
    return counts if basis == "linear" or wrap == "pinned" else np.maximum(counts - 2, 0)


def _linear(values: np.ndarray, segment: np.ndarray, t: np.ndarray) -> np.ndarray:
    after = (segment + 1) % values.shape[1]
    return values[:, segment] + (values[:, after] - values[:, segment]) * t[:, None]


def _radii(samples: np.ndarray, widths: np.ndarray, kind: str, segment: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(C, K) widths of the samples."""
    if kind == "vertex":
        return samples[..., 3]
    if kind == "varying":
        return _linear(widths[..., None], segment, t)[..., 0]
    return np.broadcast_to(widths[:, :1], samples.shape[:2])


def _hermite_lines(prim, time, curves: _Curves, which: np.ndarray, where: np.ndarray, steps: int) -> list[Lines]:
    tangents = read_array(prim, "tangents", time, (3,))
    count = where.shape[1]
    if count < 2:
        _too_short(prim, count, 2)
        return []
    if tangents is None or len(tangents) < len(curves.points):
        errors.warn_once(
            f"{prim.GetPath()}: it has fewer tangents than points, so its curves are not drawn. Author one for each."
        )
        return []
    segment, t = _parameters(steps, count - 1, False)
    ends = curves.counts
    widths, kind = _widths_at(prim, curves.widths, which, where, np.cumsum(ends) - ends, count)
    points, tangent = curves.points[where], np.asarray(tangents, np.float64)[where]
    # The same cubic with Bezier's vertices.
    inner = [points[:, :-1] + tangent[:, :-1] / 3, points[:, 1:] - tangent[:, 1:] / 3]
    bezier = np.stack([points[:, :-1], *inner, points[:, 1:]], axis=2).reshape(len(which), -1, 3)
    samples = _cubic(bezier, BASES["bezier"], segment[:, None] * 4 + np.arange(4), t)
    return [
        Lines(samples, _radii(samples, widths, "varying" if kind == "vertex" else kind, segment, t) / 2, False, which)
    ]


def _nurbs_lines(prim, time, curves: _Curves, which: np.ndarray, where: np.ndarray, steps: int) -> list[Lines]:
    orders, knots = read_array(prim, "order", time, ()), read_array(prim, "knots", time, ())
    ranges, weights = read_array(prim, "ranges", time, (2,)), read_array(prim, "pointWeights", time, ())
    whole = curves.counts
    if orders is None or knots is None or len(orders) < len(whole) or len(knots) < (whole + orders[: len(whole)]).sum():
        errors.warn_once(
            f"{prim.GetPath()}: order and knots do not fit its curves, which are not drawn. A curve of n vertices has "
            f"n + order knots."
        )
        return []
    first_knot = np.cumsum(whole + orders[: len(whole)]) - (whole + orders[: len(whole)])
    ends = np.maximum(whole - orders[: len(whole)] + 2, 0)
    lines = []
    for curve, row in zip(which, where):
        order, count = int(orders[curve]), len(row)
        if order < 2 or count < order:
            _too_short(prim, count, max(order, 2))
            continue
        own = knots[first_knot[curve] : first_knot[curve] + count + order].astype(np.float64)
        low, high = own[order - 1], own[count]
        if ranges is not None and len(ranges) > curve:
            low, high = max(low, ranges[curve][0]), min(high, ranges[curve][1])
        parameters = np.linspace(low, high, steps * (count - order + 1) + 1)
        weight = np.ones(count) if weights is None or len(weights) < len(curves.points) else weights[row]
        widths, kind = _widths_at(
            prim, curves.widths, which[which == curve], row[None], np.cumsum(ends) - ends, int(ends[curve])
        )
        at_vertices = widths[0] if kind == "vertex" else np.full(count, widths[0, 0])
        rows = np.column_stack([curves.points[row], at_vertices, np.ones(count)]) * weight[:, None]
        mixed = BSpline(own, rows, order - 1)(np.clip(parameters, low, high))
        samples = mixed[:, :4] / mixed[:, 4:]
        if kind == "varying":
            samples[:, 3] = np.interp(np.linspace(0, 1, len(samples)), np.linspace(0, 1, widths.shape[1]), widths[0])
        lines.append(Lines(samples[None, :, :3], samples[None, :, 3] / 2.0, False, np.array([curve])))
    return lines
