"""Sample UsdGeom curves as polylines with radii.

BasisCurves are evaluated with their basis, HermiteCurves with their tangents and NurbsCurves with their knots and
weights, exactly, at evenly spaced parameters of each segment: for NURBS, from each knot to the next.
"""

from typing import NamedTuple

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg import errors
from usdsdg_render.geometry.curves.widths import element_widths, interpolate_linearly, read_widths, sample_widths
from usdsdg_render.geometry.mesh_source import Primvar, read_array, read_points
from usdsdg_render.geometry.nurbs import drawn_range
from usdsdg_render.usd.tokens import token

# Rows: powers 1, t, t2, t3 of the parameter; columns: the four vertices of a segment.
BASES = {
    "bezier": np.array([[1, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1]], float),
    "bspline": np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]]) / 6.0,
    "catmullRom": np.array([[0, 2, 0, 0], [-1, 0, 1, 0], [2, -5, 4, -1], [-1, 3, -3, 1]]) / 2.0,
}


_OR_WEIGHTS = ", or its weights give no points"


class Polylines(NamedTuple):
    """Curves with equally many samples."""

    points: np.ndarray  # (C, K, 3) float64
    radii: np.ndarray  # (C, K) float64
    closed: bool  # the last sample joins the first
    curves: np.ndarray  # (C,) number of the curve in the prim
    steps: int  # samples of a segment: those with a multiple of it as their number are where segments meet


class _Curves(NamedTuple):
    """The attributes that all kinds of curves have."""

    points: np.ndarray  # (V, 3) float64
    counts: np.ndarray  # (curves,) int64 vertices of each
    widths: Primvar


class _Group(NamedTuple):
    """The curves of a prim that have equally many vertices."""

    curves: _Curves
    numbers: np.ndarray  # (C,)
    vertices: np.ndarray  # (C, V) indices of points


def read_polylines(prim: Usd.Prim, time: Usd.TimeCode, points: np.ndarray | None, steps: int) -> list[Polylines]:
    """Sample the curves of a prim, in groups of equal length; empty (with a warning) where none can be drawn.

    Args:
        points: (V, 3) skinned points; None = as authored.
        steps: samples of each segment.
    """
    curves = _read(prim, time, points)
    if curves is None:
        return []
    samplers = {"BasisCurves": _sample_basis, "HermiteCurves": _sample_hermite, "NurbsCurves": _sample_nurbs}
    starts = np.cumsum(curves.counts) - curves.counts
    polylines: list[Polylines] = []
    for count in np.unique(curves.counts):
        numbers = np.flatnonzero(curves.counts == count)
        group = _Group(curves, numbers, starts[numbers, None] + np.arange(count))
        polylines += samplers[str(prim.GetTypeName())](prim, time, group, steps)
    kept = [_drawable(each) for each in polylines]
    lost = sum(len(each.points) for each in polylines) - sum(len(each.points) for each in kept)
    if lost:
        errors.warn_once(
            f"{prim.GetPath()}: {errors.counted(lost, 'curve is', 'curves are')} not drawn, since points or widths of "
            f"it are NaN or infinite, or no width is > 0{_OR_WEIGHTS if prim.HasAttribute('pointWeights') else ''}. "
            f"Correct them."
        )
    return [each for each in kept if len(each.points)]


def count_segments(prim: Usd.Prim, time: Usd.TimeCode) -> int:
    """Return about how many segments the curves of a prim have, which decides how fine they are tessellated."""
    counts = read_array(prim, "curveVertexCounts", time, ())
    return 0 if counts is None else int(np.maximum(counts, 0).sum())


def _read(prim: Usd.Prim, time: Usd.TimeCode, points: np.ndarray | None) -> _Curves | None:
    points = read_points(prim, time) if points is None else points
    counts = read_array(prim, "curveVertexCounts", time, ())
    if points is None or counts is None or not len(points) or not len(counts):
        errors.warn_once(
            f"{prim.GetPath()}: there are no curves (no points or no curveVertexCounts), so nothing is drawn. Author "
            f"them, or remove the prim."
        )
        return None
    if (counts < 0).any() or counts.sum() > len(points):
        errors.warn_once(
            f"{prim.GetPath()}: curveVertexCounts sum to {int(counts.sum())}, and points has "
            f"{errors.counted(len(points), 'entry', 'entries')}, so the curves are not drawn. Correct them."
        )
        return None
    if left := len(points) - int(counts.sum()):
        errors.warn_once(
            f"{prim.GetPath()}: the last {errors.counted(left, 'point belongs', 'points belong')} to no curve and are "
            f"not drawn, since curveVertexCounts sum to {int(counts.sum())}. Correct them."
        )
    if read_array(prim, "normals", time, (3,)) is not None:
        errors.warn_once(f"{prim.GetPath()}: curves with normals are drawn as round tubes, not as ribbons.")
    return _Curves(np.asarray(points, np.float64), counts.astype(np.int64), read_widths(prim, time))


def _drawable(polylines: Polylines) -> Polylines:
    """The curves with finite values and some width: a width of zero is a tip."""
    usable = np.isfinite(polylines.points).all(axis=(1, 2)) & np.isfinite(polylines.radii).all(axis=1)
    usable &= (polylines.radii > 0.0).any(axis=1)
    return polylines._replace(
        points=polylines.points[usable], radii=polylines.radii[usable], curves=polylines.curves[usable]
    )


def _warn_too_short(prim: Usd.Prim, count: int, least: int) -> None:
    errors.warn_once(
        f"{prim.GetPath()}: curves of {errors.counted(count, 'vertex', 'vertices')} are not drawn, since theirs need "
        f"{least} or more. Correct curveVertexCounts."
    )


def _parameters(steps: int, segments: int, closed: bool) -> tuple[np.ndarray, np.ndarray]:
    """(K,) segments and (K,) parameters in them of the samples; an open curve has one at its very end."""
    segment = np.repeat(np.arange(segments), steps)
    t = np.tile(np.arange(steps) / steps, segments)
    if closed:
        return segment, t
    return np.append(segment, segments - 1), np.append(t, 1.0)


def _cubic(values: np.ndarray, basis: np.ndarray, vertices: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(C, K, n) values of cubics: sample k blends the vertices `vertices[k]` (K, 4) of (C, V, n) at parameter t[k]."""
    weights = np.stack([t**0, t, t**2, t**3], axis=-1) @ basis
    return np.einsum("kv,ckvn->ckn", weights, values[:, vertices])


# Kinds of curves


def _sample_basis(prim: Usd.Prim, time: Usd.TimeCode, group: _Group, steps: int) -> list[Polylines]:
    schema = UsdGeom.BasisCurves(prim)
    linear = schema.GetTypeAttr().Get(time) == UsdGeom.Tokens.linear
    basis = "linear" if linear else token(prim, "basis", time, tuple(BASES))
    wrap = token(prim, "wrap", time, ("nonperiodic", "periodic", "pinned"))
    closed = wrap == "periodic"
    count = group.vertices.shape[1]
    least = 2 if linear or (wrap == "pinned" and basis != "bezier") else 3 if closed else 4
    if count < least:
        _warn_too_short(prim, count, least)
        return []
    if basis == "bezier" and (count - (not closed)) % 3:
        errors.warn_once(
            f"{prim.GetPath()}: Bezier curves of {count} vertices have some left over, which are not drawn. "
            f"curveVertexCounts is a multiple of 3{'' if closed else ', plus 1'}."
        )
        if closed:  # else its end would not be its beginning
            group = group._replace(vertices=group.vertices[:, : count // 3 * 3])
    ends = _varying_counts(basis, wrap, group.curves.counts)
    segments = int(ends[group.numbers[0]]) - (not closed)
    steps = 1 if linear else steps
    segment, t = _parameters(steps, segments, closed)
    widths, kind = element_widths(prim, group.curves.widths, group.numbers, group.vertices, ends)
    values = group.curves.points[group.vertices]
    if kind == "vertex":
        values = np.concatenate([values, widths[..., None]], axis=-1)
    if linear:
        samples = interpolate_linearly(values, segment, t)
    else:
        if wrap == "pinned" and basis != "bezier":  # phantom vertices, so that the curve reaches its ends
            first, last = 2 * values[:, :1] - values[:, 1:2], 2 * values[:, -1:] - values[:, -2:-1]
            values = np.concatenate([first, values, last], axis=1)
        step = 3 if basis == "bezier" else 1
        vertices = (segment[:, None] * step + np.arange(4)) % values.shape[1]
        samples = _cubic(values, BASES[basis], vertices, t)
    radii = sample_widths(samples, widths, kind, segment, t) / 2.0
    return [Polylines(samples[..., :3], radii, closed, group.numbers, steps)]


def varying_counts(prim: Usd.Prim, time: Usd.TimeCode) -> np.ndarray | None:
    """Return the number of varying values of each curve; None of NURBS, whose ends of segments are their knots."""
    counts = read_array(prim, "curveVertexCounts", time, ())
    kind = str(prim.GetTypeName())
    if counts is None or kind not in ("BasisCurves", "HermiteCurves"):
        return None
    counts = np.maximum(counts.astype(np.int64), 0)
    if kind == "HermiteCurves":
        return counts
    linear = UsdGeom.BasisCurves(prim).GetTypeAttr().Get(time) == UsdGeom.Tokens.linear
    basis = "linear" if linear else token(prim, "basis", time, tuple(BASES))
    return _varying_counts(basis, token(prim, "wrap", time, ("nonperiodic", "periodic", "pinned")), counts)


def _varying_counts(basis: str, wrap: str, counts: np.ndarray) -> np.ndarray:
    """(curves,) number of varying values of each curve: one for each end of a segment."""
    if wrap == "periodic":
        return counts // 3 if basis == "bezier" else counts
    if basis == "bezier":
        return np.maximum(counts - 1, 0) // 3 + 1
    return counts if basis == "linear" or wrap == "pinned" else np.maximum(counts - 2, 0)


def _sample_hermite(prim: Usd.Prim, time: Usd.TimeCode, group: _Group, steps: int) -> list[Polylines]:
    tangents = read_array(prim, "tangents", time, (3,))
    curves, count = group.curves, group.vertices.shape[1]
    if count < 2:
        _warn_too_short(prim, count, 2)
        return []
    if tangents is None or len(tangents) < len(curves.points):
        errors.warn_once(
            f"{prim.GetPath()}: it has fewer tangents than points, so its curves are not drawn. Author one for each."
        )
        return []
    segment, t = _parameters(steps, count - 1, False)
    widths, kind = element_widths(prim, curves.widths, group.numbers, group.vertices, curves.counts)
    points, tangent = curves.points[group.vertices], np.asarray(tangents, np.float64)[group.vertices]
    # The Bezier control points of the same cubic.
    inner = [points[:, :-1] + tangent[:, :-1] / 3, points[:, 1:] - tangent[:, 1:] / 3]
    bezier = np.stack([points[:, :-1], *inner, points[:, 1:]], axis=2).reshape(len(points), -1, 3)
    samples = _cubic(bezier, BASES["bezier"], segment[:, None] * 4 + np.arange(4), t)
    radii = sample_widths(samples, widths, "varying" if kind == "vertex" else kind, segment, t) / 2
    return [Polylines(samples, radii, False, group.numbers, steps)]


def _sample_nurbs(prim: Usd.Prim, time: Usd.TimeCode, group: _Group, steps: int) -> list[Polylines]:
    orders, knots = read_array(prim, "order", time, ()), read_array(prim, "knots", time, ())
    ranges, weights = read_array(prim, "ranges", time, (2,)), read_array(prim, "pointWeights", time, ())
    curves, counts = group.curves, group.curves.counts
    orders = None if orders is None or len(orders) < len(counts) else orders[: len(counts)]
    if orders is None or knots is None or len(knots) < (counts + orders).sum():
        errors.warn_once(
            f"{prim.GetPath()}: order and knots do not fit its curves, which are not drawn. A curve of n vertices has "
            f"n + order knots."
        )
        return []
    from scipy.interpolate import BSpline

    first_knot = np.cumsum(counts + orders) - (counts + orders)
    ends = np.maximum(counts - orders + 2, 0)
    polylines: list[Polylines] = []
    for curve, row in zip(group.numbers, group.vertices):
        order, count = int(orders[curve]), len(row)
        curve_knots = knots[first_knot[curve] : first_knot[curve] + count + order].astype(np.float64)
        own_range = None if ranges is None or len(ranges) <= curve else np.asarray(ranges[curve], np.float64)
        drawn = drawn_range(str(prim.GetPath()), order, curve_knots, count, own_range)
        if drawn is None:
            continue
        low, high = drawn
        inner = curve_knots[(curve_knots > low) & (curve_knots < high)]
        joints = np.unique([low, *inner, high])  # a curve may have corners there
        own_steps = 1 if order == 2 else steps
        segment, t = _parameters(own_steps, len(joints) - 1, False)
        parameters = joints[segment] + (joints[segment + 1] - joints[segment]) * t
        weight = np.ones(count) if weights is None or len(weights) < len(curves.points) else weights[row]
        widths, kind = element_widths(prim, curves.widths, np.array([curve]), row[None], ends)
        at_vertices = widths[0] if kind == "vertex" else np.full(count, widths[0, 0])
        rows = np.column_stack([curves.points[row], at_vertices, np.ones(count)]) * weight[:, None]
        homogeneous = BSpline(curve_knots, rows, order - 1)(np.clip(parameters, low, high))
        with np.errstate(divide="ignore", invalid="ignore"):  # weights of zero; `_drawable` looks at what comes of them
            samples = homogeneous[:, :4] / homogeneous[:, 4:]
        if kind == "varying":
            samples[:, 3] = np.interp(parameters, curve_knots[order - 1 : count + 1], widths[0])
        radii = samples[None, :, 3] / 2.0
        polylines.append(Polylines(samples[None, :, :3], radii, False, np.array([curve]), own_steps))
    return polylines
