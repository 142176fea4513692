"""Widths of curves and points: diameters as authored, and at the samples of curves."""

import numpy as np
from pxr import Usd

from usdsdg import errors
from usdsdg_render.geometry.mesh_source import Primvar, read_array, read_primvar

DEFAULT_WIDTH = 1.0  # of prims without widths [stage units], as Hydra draws them


def read_widths(prim: Usd.Prim, time: Usd.TimeCode) -> Primvar:
    """Read diameters of curves or points. `primvars:widths` wins over `widths`, which are `vertex` unless authored."""
    primvar = read_primvar(prim, "primvars:widths", time, ())
    if primvar is not None:
        return primvar
    values = read_array(prim, "widths", time, ())
    if values is None or not len(values):
        errors.warn_once(
            f"{prim.GetPath()}: it has no widths, so {DEFAULT_WIDTH} is used. Author widths [stage units]."
        )
        return Primvar(np.full(1, DEFAULT_WIDTH), np.zeros(0, np.int32), "constant")
    interpolation = prim.GetAttribute("widths").GetMetadata("interpolation")
    return Primvar(values, np.zeros(0, np.int32), "constant" if len(values) == 1 else str(interpolation or "vertex"))


def width_values(prim: Usd.Prim, widths: Primvar) -> np.ndarray:
    """Return widths by their indices; where these are out of range the first one, with a warning."""
    values = np.asarray(widths.values, np.float64)
    if not len(widths.indices):
        return values
    outside = (widths.indices < 0) | (widths.indices >= len(values))
    if outside.any():
        entries = errors.counted(int(outside.sum()), "entry", "entries")
        errors.warn_once(
            f"{prim.GetPath()}: {entries} of primvars:widths:indices outside of its "
            f"{errors.counted(len(values), 'width')}; the first one is used there. Correct primvars:widths:indices."
        )
    return values[np.where(outside, 0, widths.indices)]


def element_widths(
    prim: Usd.Prim, widths: Primvar, curves: np.ndarray, vertices: np.ndarray, varying_counts: np.ndarray
) -> tuple[np.ndarray, str]:
    """Widths of curves with equally many vertices, one row a curve, and what their columns are.

    Args:
        curves: (C,) numbers of the curves.
        vertices: (C, V) their vertices.
        varying_counts: number of varying values of each curve of the prim, equal for those in `curves`.

    Returns:
        ((C, V) widths, "vertex"), ((C, E) widths, "varying") or ((C, 1) widths, "constant").
    """
    values = width_values(prim, widths)
    first_varying = np.cumsum(varying_counts) - varying_counts
    rows = {
        "uniform": curves[:, None],
        "vertex": vertices,
        "varying": first_varying[curves, None] + np.arange(int(varying_counts[curves[0]])),
    }.get(widths.interpolation, np.zeros((len(curves), 1), np.int64))
    if rows.size and rows.max() >= len(values):
        errors.warn_once(
            f"{prim.GetPath()}: the {widths.interpolation} widths have {errors.counted(len(values), 'value')}, too few "
            f"for the curves; the first one is used. Author one per element or correct the interpolation."
        )
        rows = np.zeros((len(curves), 1), np.int64)
    kind = widths.interpolation if rows.shape[1] > 1 else "constant"
    return values[rows], kind


def interpolate_linearly(values: np.ndarray, segment: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(C, K, n) values at parameters t (K,) of segments (K,), of (C, V, n) values at the ends of segments."""
    after = (segment + 1) % values.shape[1]
    return values[:, segment] + (values[:, after] - values[:, segment]) * t[:, None]


def sample_widths(samples: np.ndarray, widths: np.ndarray, kind: str, segment: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(C, K) widths of samples; `vertex` ones were interpolated with the positions to column 3 of `samples`."""
    if kind == "vertex":
        return samples[..., 3]
    if kind == "varying":
        return interpolate_linearly(widths[..., None], segment, t)[..., 0]
    return np.broadcast_to(widths[:, :1], samples.shape[:2])
