"""Warnings of displayColor and displayOpacity that do not fit their gprim, or that are drawn as one color."""

from pxr import Usd, UsdGeom

from usdsdg import errors
from usdsdg_render.geometry.mesh_source import read_primvar, value_at

# The array with one entry for each element of an interpolation.
_ELEMENTS = {
    UsdGeom.Mesh: {
        "uniform": "faceVertexCounts",
        "varying": "points",
        "vertex": "points",
        "faceVarying": "faceVertexIndices",
    },
    UsdGeom.Points: {"varying": "points", "vertex": "points"},
    UsdGeom.Curves: {"uniform": "curveVertexCounts"},
}


def warn_of_colors(prim: Usd.Prim, time: Usd.TimeCode, *, by_mean: bool) -> None:
    """Warn of what is wrong with the colors and opacities of a gprim over which they vary.

    by_mean: whether it is drawn with their means.
    """
    is_explained = False
    for name, tail in (("displayColor", (3,)), ("displayOpacity", ())):
        excess, fault = _faults(prim, name, tail, time)
        if fault and by_mean:
            errors.warn_once(
                f"{prim.GetPath()}: {fault}, so the means of displayColor and displayOpacity are used. Author one "
                "value for each element, or correct the interpolation."
            )
            is_explained = True
        elif excess:
            errors.warn_once(
                f"{prim.GetPath()}: {excess}; those at the end are ignored. Author one value for each element, or "
                f"correct the interpolation."
            )
    if by_mean and not is_explained:
        errors.warn_once(
            f"{prim.GetPath()}: displayColor or displayOpacity varies over the gprim; its mean is used. Bind a "
            f"material with a texture instead, or none where other inputs have textures."
        )


def _faults(prim: Usd.Prim, name: str, tail: tuple[int, ...], time: Usd.TimeCode) -> tuple[str, str]:
    """What primvars:`name` has too much of, and what it lacks; "" where it is right."""
    primvar = read_primvar(prim, f"primvars:{name}", time, tail)
    wanted = None if primvar is None else _count(prim, primvar.interpolation, time)
    if primvar is None or wanted is None:
        return "", ""
    values, indices = primvar.values, primvar.indices
    given, noun = (len(indices), "indices") if len(indices) else (len(values), "values")
    if given < wanted and len(values) > 1:
        return "", f"the {given} {noun} of its {primvar.interpolation} {name} are too few for {wanted}"
    wrong = indices[(indices < 0) | (indices >= len(values))]
    if len(wrong):
        count = errors.counted(len(wrong), f"index of its {name} is", f"indices of its {name} are")
        return "", f"{count} outside its {errors.counted(len(values), 'value')} (first: {int(wrong[0])})"
    if given > wanted:
        return f"the {given} {noun} of its {primvar.interpolation} {name} are more than {wanted}", ""
    return "", ""


def _count(prim: Usd.Prim, interpolation: str, time: Usd.TimeCode) -> int | None:
    """How many values an interpolation takes; None where it says nothing of the gprim."""
    names = next((names for schema, names in _ELEMENTS.items() if prim.IsA(schema)), {})
    elements = value_at(prim.GetAttribute(names[interpolation]), time) if interpolation in names else None
    return None if elements is None else len(elements)
