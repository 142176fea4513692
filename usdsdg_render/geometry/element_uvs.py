"""Texture coordinates of curves and points: one place of the picture for each of them."""

import numpy as np
from pxr import Usd

from usdsdg import errors
from usdsdg_render.geometry.mesh_source import read_uvs


def element_uvs(
    prim: Usd.Prim, time: Usd.TimeCode, uv_name: str, elements: np.ndarray, interpolations: tuple[str, ...]
) -> np.ndarray | None:
    """(N, 2) float32 texture coordinates of elements of a gprim, such as the curves of a BasisCurves.

    None where there are none, or (with a warning) an interpolation other than constant and `interpolations`, or too
    few values: then each element shows the whole picture.
    """
    primvar = read_uvs(prim, time, uv_name)
    if primvar is None:
        return None
    wanted = " or ".join(interpolations)
    if primvar.interpolation not in ("constant", *interpolations):
        errors.warn_once(
            f"{prim.GetPath()}: its {primvar.interpolation} texture coordinates do not count: each element shows the "
            f"whole picture. Author one value for each, with the interpolation {wanted}."
        )
        return None
    rows = elements if primvar.interpolation != "constant" else np.zeros_like(elements)
    fits = rows.max(initial=0) < len(primvar.indices if len(primvar.indices) else primvar.values)
    if fits and len(primvar.indices):
        rows = primvar.indices[rows]
    if not fits or rows.max(initial=0) >= len(primvar.values) or rows.min(initial=0) < 0:
        errors.warn_once(
            f"{prim.GetPath()}: its {primvar.interpolation} texture coordinates have "
            f"{errors.counted(len(primvar.values), 'value')}, too few, or indices out of range, so each element shows "
            f"the whole picture. Author one value for each."
        )
        return None
    return np.nan_to_num(primvar.values[rows].astype(np.float32), posinf=0.0, neginf=0.0)
