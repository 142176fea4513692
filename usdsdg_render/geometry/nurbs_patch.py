"""UsdGeomNurbsPatch to a mesh: a grid of quads whose corners lie on the surface, with its own normals there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from pxr import Usd

from usdsdg import errors
from usdsdg.stage.geometry.skinning import Skinning
from usdsdg_render.geometry.mesh_source import (
    EMPTY,
    MeshSource,
    Primvar,
    read_array,
    read_colors,
    read_points,
    read_primvar,
    read_uvs,
    value_at,
)
from usdsdg_render.usd.authored_values import as_floats
from usdsdg_render.usd.tokens import token

# Segments of each span of knots: the most with which a patch has no more quads than that.
_SEGMENTS = (16, 8, 4, 2, 1)
_MOST_QUADS = 200_000


class _Direction(NamedTuple):
    """Samples along u or v: those of one span of knots after those of the one before.

    Where spans meet there are two samples of one parameter, since there the surface may have an edge.
    """

    values: np.ndarray  # (samples, vertices) basis functions
    slopes: np.ndarray  # their derivatives
    fractions: np.ndarray  # (samples,) from 0 to 1 over what is drawn
    segments: int

    def corners(self) -> np.ndarray:
        """Return the first sample of each segment."""
        return np.flatnonzero(np.arange(len(self.fractions)) % (self.segments + 1) < self.segments)


class _Grid(NamedTuple):
    """A surface where it is sampled, rows along v and columns along u."""

    u: _Direction
    v: _Direction
    weights: np.ndarray  # (V, U) of control points

    def sample(self, values: np.ndarray) -> np.ndarray:
        """Return the values of control points, (V, U, n), on the surface, (rows, columns, n)."""
        return self._sum(self.v.values, self.u.values, values) / self._sum(self.v.values, self.u.values)

    def normals(self, points: np.ndarray) -> np.ndarray:
        """Return the cross products of the derivatives along u and v of control points, not unit."""
        surface, weight = self.sample(points), self._sum(self.v.values, self.u.values)
        along_u, along_v = (
            (self._sum(v, u, points) - self._sum(v, u) * surface) / weight
            for v, u in ((self.v.values, self.u.slopes), (self.v.slopes, self.u.values))
        )
        return np.cross(along_u, along_v)

    def _sum(self, v: np.ndarray, u: np.ndarray, values: np.ndarray | float = 1.0) -> np.ndarray:
        weighted = self.weights[..., None] * values
        return np.einsum("ai,ijn,bj->abn", v, weighted, u, optimize=True)

    def quads(self) -> np.ndarray:
        """Return (Q, 4) samples, counter-clockwise seen from where u x v points to."""
        columns = len(self.u.fractions)
        first = (self.v.corners()[:, None] * columns + self.u.corners()).ravel()
        return first[:, None] + np.array([0, 1, columns + 1, columns])


def read_patch(
    prim: Usd.Prim, time: Usd.TimeCode, skinning: Skinning, *, uv_name: str = "", colored: tuple[int, ...] = ()
) -> MeshSource | None:
    """Read a patch as a mesh; None, with a warning, where it has no surface. Arguments as of `read_mesh`."""
    path = str(prim.GetPath())
    u_count, v_count = (_integer(prim, f"{way}VertexCount", time) for way in "uv")
    points = _points(prim, time, skinning, u_count * v_count)
    if points is None:
        return None
    u_spans, v_spans = _spans(prim, "u", u_count, time), _spans(prim, "v", v_count, time)
    if u_spans is None or v_spans is None:
        return None
    if (trims := read_array(prim, "trimCurve:counts", time, ())) is not None and len(trims):
        errors.warn_once(f"{path}: its trim curves are not supported; all of it is drawn. Convert it to a Mesh.")
    count = len(u_spans.lows) * len(v_spans.lows)
    segments = next((each for each in _SEGMENTS if count * each**2 <= _MOST_QUADS), 1)
    weights = read_array(prim, "pointWeights", time, ())
    if weights is None or len(weights) != len(points) or not (weights > 0).all():
        if weights is not None and len(weights):
            errors.warn_once(f"{path}: pointWeights are not one above 0 for each point, and are ignored. Correct them.")
        weights = np.ones(len(points))
    shape = v_count, u_count
    grid = _Grid(u_spans.sampled(segments), v_spans.sampled(segments), weights.astype(np.float64).reshape(shape))
    return _as_mesh(prim, time, grid, points.reshape(*shape, 3), uv_name, colored)


def _points(prim: Usd.Prim, time: Usd.TimeCode, skinning: Skinning, count: int) -> np.ndarray | None:
    """Read the control points, those of a skeleton posed; None, with a warning, where there are not `count`."""
    skin = skinning.skin(prim, time)
    points = read_points(prim, time) if skin is None else np.asarray(skin.points)
    found = 0 if points is None else len(points)
    if points is None or not found or found != count:
        errors.warn_once(
            f"{prim.GetPath()}: it has {errors.counted(found, 'point')}, and uVertexCount times vVertexCount is "
            f"{count}, so it is not drawn. Author one point for each."
        )
        return None
    if not np.isfinite(points).all():
        errors.warn_once(f"{prim.GetPath()}: a point is NaN or infinite, so it is not drawn. Correct its points.")
        return None
    return points.astype(np.float64)


def _integer(prim: Usd.Prim, name: str, time: Usd.TimeCode) -> int:
    value = value_at(prim.GetAttribute(name), time)
    return value if isinstance(value, int) else 0


class _Spans(NamedTuple):
    """The parts between the knots of one direction, each with polynomials for its basis functions."""

    coefficients: np.ndarray  # (order, spans, vertices) highest power first, of the distance from the knot before
    knots: np.ndarray  # (spans,) those before each span
    lows: np.ndarray  # (spans,) the parameters that are drawn
    highs: np.ndarray

    def sampled(self, segments: int) -> _Direction:
        """Sample each span at the ends of `segments`; one is enough where all is linear."""
        count = segments if len(self.coefficients) > 2 else 1
        parameters = self.lows[:, None] + (self.highs - self.lows)[:, None] * np.linspace(0, 1, count + 1)
        offsets = (parameters - self.knots[:, None])[..., None]
        values, slopes = np.zeros((2, *parameters.shape, self.coefficients.shape[-1]))
        for each in self.coefficients[:, :, None, :]:
            slopes = slopes * offsets + values
            values = values * offsets + each
        fractions = (parameters - self.lows[0]) / (self.highs[-1] - self.lows[0])
        flat = values.shape[-1]
        return _Direction(values.reshape(-1, flat), slopes.reshape(-1, flat), fractions.ravel(), count)


def _spans(prim: Usd.Prim, way: str, count: int, time: Usd.TimeCode) -> _Spans | None:
    """Read the spans of a direction, "u" or "v", that are drawn; None, with a warning, where there are none."""
    from scipy.interpolate import BSpline, PPoly

    order = _integer(prim, f"{way}Order", time)
    knots = read_array(prim, f"{way}Knots", time, ())
    knots = np.zeros(0) if knots is None else knots.astype(np.float64)
    fits = 2 <= order <= count and len(knots) == count + order and np.isfinite(knots).all()
    if not fits or (np.diff(knots) < 0).any() or knots[order - 1] >= knots[count]:
        errors.warn_once(
            f"{prim.GetPath()}: {way}Order {order}, {way}VertexCount {count} and {way}Knots, of which it has "
            f"{len(knots)}, give no surface, so it is not drawn. Author an order of 2 or more, at least as many "
            f"vertices, and as many knots as both together, which do not decrease."
        )
        return None
    low, high = knots[order - 1], knots[count]
    if (authored := value_at(prim.GetAttribute(f"{way}Range"), time)) is not None:
        drawn = as_floats(authored, 2) or (np.nan, np.nan)
        first, last = max(low, drawn[0]), min(high, drawn[1])
        if first < last and np.isfinite(drawn).all():
            low, high = first, last
        else:
            errors.warn_once(
                f"{prim.GetPath()}: {way}Range {drawn} names no part of a surface whose knots go from {low:g} "
                f"to {high:g}; all of it is drawn. Correct {way}Range."
            )
    functions = [PPoly.from_spline(BSpline(knots, each, order - 1)).c for each in np.eye(count)]
    before, after = knots[:-1], knots[1:]
    kept = np.flatnonzero((before < after) & (before < high) & (after > low))
    coefficients = np.stack(functions, axis=-1)[:, kept]
    return _Spans(coefficients, before[kept], np.maximum(before[kept], low), np.minimum(after[kept], high))


def _as_mesh(
    prim: Usd.Prim, time: Usd.TimeCode, grid: _Grid, points: np.ndarray, uv_name: str, colored: tuple[int, ...]
) -> MeshSource:
    quads, surface = grid.quads(), grid.sample(points)
    normals = grid.normals(points).reshape(-1, 3)
    normals = np.where(_is_small(normals)[:, None], 0.0, normals)  # as at poles, where those of the faces count
    left_handed = token(prim, "orientation", time, ("rightHanded", "leftHanded")) == "leftHanded"
    shape, flat = points.shape[:2], surface.reshape(-1, 3)
    uvs = None if colored else _on_surface(prim, read_uvs(prim, time, uv_name), grid, shape)
    if uvs is None and not colored:
        own = np.stack(np.meshgrid(grid.u.fractions, grid.v.fractions), axis=-1).reshape(-1, 2)
        uvs = Primvar(own.astype(np.float32), EMPTY, "vertex")
    colors = _on_surface(prim, read_colors(prim, time), grid, shape) if colored else None
    opacities = (
        _on_surface(prim, read_primvar(prim, "primvars:displayOpacity", time, ()), grid, shape) if colored else None
    )
    return MeshSource(
        points=flat.astype(np.float32),
        counts=np.full(len(quads), 4, np.int32),
        indices=quads.ravel().astype(np.int32),
        holes=EMPTY,
        normals=Primvar((-normals if left_handed else normals).astype(np.float32), EMPTY, "vertex"),
        uvs=uvs,
        subsets=(),
        left_handed=left_handed,
        scheme="none",
        colors=colors,
        opacities=opacities,
        colored=colored,
    )


def _is_small(normals: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(normals, axis=-1)
    return lengths <= 1e-6 * lengths.max()


def _on_surface(prim: Usd.Prim, primvar: Primvar | None, grid: _Grid, shape: tuple[int, ...]) -> Primvar | None:
    """Return a primvar of control points where the surface is sampled; of other kinds the mean, with a warning."""
    if primvar is None or not len(primvar.values):
        return None
    values, indices = primvar.values, primvar.indices
    if len(indices) and indices.min() >= 0 and indices.max() < len(values):
        values = values[indices]
    if primvar.interpolation == "vertex" and len(values) == shape[0] * shape[1]:
        sampled = grid.sample(values.astype(np.float64).reshape(*shape, -1))
        return Primvar(sampled.reshape(-1, *values.shape[1:]).astype(np.float32), EMPTY, "vertex")
    if len(values) > 1 and primvar.interpolation != "constant":
        errors.warn_once(
            f"{prim.GetPath()}: primvars of a NurbsPatch that are {primvar.interpolation} are not supported; the mean "
            f"is used. Author one value for each point, with the interpolation vertex."
        )
        return Primvar(values.mean(axis=0, keepdims=True), EMPTY, "constant")
    return Primvar(values[:1], EMPTY, "constant")
