"""Curves are in their 3D boxes, and touch them: SciPy's splines are the oracle."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom, Vt
from scipy.interpolate import BSpline, CubicHermiteSpline

from usdsdg.annotators.bounds.hulls import read_hull
from usdsdg.stage.geometry.skinning import Skinning

ZIGZAG = np.array([(0, 0, 0), (1, 2, 0), (3, -1, 1), (4, 1, 0), (6, 0, 2), (7, 3, 0), (9, 0, 0)], float)
TANGENTS = np.array([(1, 9, 0), (0, -4, 2), (5, 0, 0), (0, 0, 7), (-3, 1, 0), (0, 8, -6), (2, 2, 2)], float)
TIMES = np.linspace(0, 1, 400)


def bezier(points):
    knots = np.repeat([0.0, 1.0], 4)
    return np.concatenate([BSpline(knots, points[first : first + 4], 3)(TIMES) for first in (0, 3)])


def bspline(points):
    count = len(points)
    return BSpline(np.arange(count + 4.0), points, 3)(np.linspace(3, count, 3000))


def through(points, tangents):
    return CubicHermiteSpline(np.arange(len(points)), points, tangents)(np.linspace(0, len(points) - 1, 3000))


def catmull_rom(points):
    return through(points[1:-1], (points[2:] - points[:-2]) / 2)


def extended(points):
    return np.concatenate([2 * points[:1] - points[1:2], points, 2 * points[-1:] - points[-2:-1]])


CURVES = {
    "bezier nonperiodic": bezier(ZIGZAG),
    "bspline nonperiodic": bspline(ZIGZAG),
    "bspline pinned": bspline(extended(ZIGZAG)),
    "bspline periodic": bspline(np.concatenate([ZIGZAG, ZIGZAG[:3]])),
    "catmullRom nonperiodic": catmull_rom(ZIGZAG),
    "catmullRom pinned": catmull_rom(extended(ZIGZAG)),
    "catmullRom periodic": catmull_rom(np.concatenate([ZIGZAG, ZIGZAG[:3]])),
    "hermite": through(ZIGZAG, TANGENTS),
    "linear": ZIGZAG,
}


def bounds(kind: str) -> np.ndarray:
    stage = Usd.Stage.CreateInMemory()
    curves = stage.DefinePrim("/Hair", "HermiteCurves" if kind == "hermite" else "BasisCurves")
    curves.GetAttribute("points").Set(Vt.Vec3fArray.FromNumpy(ZIGZAG.astype(np.float32)))
    curves.GetAttribute("curveVertexCounts").Set([len(ZIGZAG)])
    curves.GetAttribute("widths").Set([0.2])
    UsdGeom.Curves(curves).SetWidthsInterpolation("constant")
    if kind == "hermite":
        curves.GetAttribute("tangents").Set(Vt.Vec3fArray.FromNumpy(TANGENTS.astype(np.float32)))
    elif kind == "linear":
        curves.GetAttribute("type").Set("linear")
    else:
        for name, value in zip(("basis", "wrap"), kind.split()):
            curves.GetAttribute(name).Set(value)
    hull = read_hull(curves, Usd.TimeCode.Default(), Skinning())
    assert hull is not None
    return hull(np.eye(4))


@pytest.mark.parametrize("kind", CURVES)
def test_a_curve_touches_its_box(kind):
    curve = CURVES[kind]
    np.testing.assert_allclose(bounds(kind), [curve.min(axis=0) - 0.1, curve.max(axis=0) + 0.1], atol=5e-3)


def test_widths_of_hermite_curves_run_evenly_between_vertices():
    """As they are drawn. The curve goes straight up, and is widest above, where it is not at its end."""
    stage = Usd.Stage.CreateInMemory()
    curves = stage.DefinePrim("/Hair", "HermiteCurves")
    curves.GetAttribute("points").Set([(0, 0, 0), (1, 0, 0)])
    curves.GetAttribute("tangents").Set([(1, 4, 0), (1, -4, 0)])
    curves.GetAttribute("curveVertexCounts").Set([2])
    curves.GetAttribute("widths").Set([0.0, 2.0])
    hull = read_hull(curves, Usd.TimeCode.Default(), Skinning())
    assert hull is not None
    curve = CubicHermiteSpline([0, 1], [(0, 0, 0), (1, 0, 0)], [(1, 4, 0), (1, -4, 0)])(TIMES)
    np.testing.assert_allclose(hull(np.eye(4))[1, 1], (curve[:, 1] + TIMES).max(), atol=2e-3)


def test_of_many_segments_the_box_is_that_of_bezier_control_points(monkeypatch):
    monkeypatch.setattr("usdsdg.annotators.bounds.curves._MOST_SAMPLED", 1)
    curve, (low, high) = CURVES["catmullRom pinned"], bounds("catmullRom pinned")
    assert (low <= curve.min(axis=0) - 0.1 + 1e-6).all()
    assert (high >= curve.max(axis=0) + 0.1 - 1e-6).all()
    assert (high - low <= np.ptp(curve, axis=0) + 0.2 + 0.4).all()
