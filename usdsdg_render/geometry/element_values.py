"""Colors and texture coordinates of curves and points: one value for each, and along curves those of their vertices."""

import numpy as np
from pxr import Usd

from usdsdg import errors
from usdsdg_render.geometry.curves.polylines import read_polylines, varying_counts
from usdsdg_render.geometry.curves.tubes import Tessellation
from usdsdg_render.geometry.face_varying import DEFAULT_COLOR
from usdsdg_render.geometry.mesh_source import Primvar, read_array, read_colors, read_primvar, read_uvs
from usdsdg_render.usd.prim_kinds import CURVES, kind_of


def element_colors(prim: Usd.Prim, time: Usd.TimeCode, surface: Tessellation) -> np.ndarray | None:
    """(T, 3, 4) float32 linear displayColor and displayOpacity at the corners of triangles.

    None where a primvar has an interpolation that these gprims do not have, or too few values.
    """
    result = np.ones((*surface.triangles.shape, 4), np.float32)
    result[..., :3] = DEFAULT_COLOR
    opacity = read_primvar(prim, "primvars:displayOpacity", time, ())
    for primvar, columns in ((read_colors(prim, time), slice(0, 3)), (opacity, slice(3, 4))):
        if primvar is not None:
            values = _at_corners(prim, time, primvar, surface)
            if values is None:
                return None
            result[..., columns] = np.nan_to_num(values)
    return result


def element_uvs(prim: Usd.Prim, time: Usd.TimeCode, uv_name: str, surface: Tessellation) -> np.ndarray | None:
    """(T, 3, 2) float32 texture coordinates at the corners of triangles.

    None where there are none, or (with a warning) ones that do not fit: then each element shows the whole picture.
    """
    primvar = read_uvs(prim, time, uv_name)
    values = None if primvar is None else _at_corners(prim, time, primvar, surface)
    if primvar is not None and values is None:
        errors.warn_once(
            f"{prim.GetPath()}: its {primvar.interpolation} texture coordinates, "
            f"{errors.counted(len(primvar.values), 'value')}, do not fit, so each element shows the whole picture. "
            f"Author one value for each {'curve (uniform) or vertex' if kind_of(prim) == CURVES else 'point (vertex)'}."
        )
    return values


def _at_corners(prim: Usd.Prim, time: Usd.TimeCode, primvar: Primvar, surface: Tessellation) -> np.ndarray | None:
    """(T, 3, n) float32 values of a primvar; None where they do not fit."""
    is_curves = kind_of(prim) == CURVES
    values = primvar.values.reshape(len(primvar.values), -1)
    if primvar.interpolation == "constant" or len(values) == 1:
        return np.broadcast_to(values[:1, None], (*surface.triangles.shape, values.shape[1])).astype(np.float32)
    if len(primvar.indices):
        if primvar.indices.min() < 0 or primvar.indices.max() >= len(values):
            return None
        values = values[primvar.indices]
    if primvar.interpolation in ("vertex", "varying") and is_curves:
        return _along(prim, time, values, surface, is_vertex=primvar.interpolation == "vertex")
    if primvar.interpolation not in (("uniform",) if is_curves else ("vertex", "varying")):
        return None
    if surface.owners.max(initial=0) >= len(values):
        return None
    return np.repeat(values[surface.owners, None], 3, axis=1).astype(np.float32)


def _along(
    prim: Usd.Prim, time: Usd.TimeCode, values: np.ndarray, surface: Tessellation, *, is_vertex: bool
) -> np.ndarray | None:
    """(T, 3, n) values that run evenly between the ends of segments: `varying` ones, or what `vertex` ones are there.

    None where they do not fit.
    """
    ends = _ends_of_vertices(prim, time, values) if is_vertex else _ends_of_segments(prim, time, values)
    if ends is None or not all(len(ends.get(curve, ())) for curve in np.unique(surface.owners).tolist()):
        return None
    curves = sorted(ends)
    counts = np.zeros(curves[-1] + 1, np.int64)
    counts[curves] = [len(ends[curve]) for curve in curves]
    first = (np.cumsum(counts) - counts)[surface.owners, None]
    count = counts[surface.owners, None]
    segments = count if _is_closed(prim, time) else count - 1
    # Along a tube the second texture coordinate runs from 0 to 1 with its segments.
    place = surface.uvs[..., 1].astype(np.float64) * segments
    before = np.clip(np.floor(place).astype(np.int64), 0, np.maximum(segments - 1, 0))
    flat, share = np.concatenate([ends[curve] for curve in curves]), (place - before)[..., None]
    here, after = flat[first + before], flat[first + (before + 1) % count]
    return (here + (after - here) * share).astype(np.float32)


def _is_closed(prim: Usd.Prim, time: Usd.TimeCode) -> bool:
    wrap = prim.GetAttribute("wrap")
    return bool(wrap) and wrap.Get(time) == "periodic"


def _ends_of_vertices(prim: Usd.Prim, time: Usd.TimeCode, values: np.ndarray) -> dict[int, np.ndarray] | None:
    """Values at the ends of the segments of each curve, by its number, of those of vertices."""
    points = read_array(prim, "points", time, (3,))
    if points is None or len(values) < len(points):
        return None
    columns = np.zeros((len(points), 3))
    columns[:, : values.shape[1]] = np.nan_to_num(values[: len(points)])
    groups = read_polylines(prim, time, columns, 1)  # as their points are
    return {
        curve: row[:, : values.shape[1]] for group in groups for curve, row in zip(group.curves.tolist(), group.points)
    }


def _ends_of_segments(prim: Usd.Prim, time: Usd.TimeCode, values: np.ndarray) -> dict[int, np.ndarray] | None:
    counts = varying_counts(prim, time)
    if counts is None or counts.sum() > len(values):
        return None
    return dict(enumerate(np.split(values[: counts.sum()], np.cumsum(counts)[:-1])))
