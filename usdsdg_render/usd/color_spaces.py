"""Colors of a stage in the renderer's linear Rec. 709, by the color space that USD gives an attribute.

That is the attribute's `colorSpace`, else the one of the nearest prim at or above it with a ColorSpaceAPI, else linear
Rec. 709.
"""

from typing import Any

import numpy as np
from pxr import Gf, Usd

from usdsdg import errors
from usdsdg.stage.time_code import current_value

_AS_THEY_ARE = frozenset(
    ("", "lin_rec709_scene", "lin_rec709", "lin_srgb", "linear", "raw", "data", "identity", "unknown", "auto")
)
# Names of earlier versions and of MaterialX, beside those that lack USD's ending only.
_OTHER_NAMES = {"sRGB": "srgb_rec709_scene", "srgb_texture": "srgb_rec709_scene", "acescg": "lin_ap1_scene"}
_COLORS = {
    Gf.Vec3f: Gf.Vec3f, Gf.Vec3d: Gf.Vec3d, Gf.Vec3h: Gf.Vec3f,
    Gf.Vec4f: Gf.Vec4f, Gf.Vec4d: Gf.Vec4d, Gf.Vec4h: Gf.Vec4f,
}  # fmt: skip
_RENDERED = Gf.ColorSpace(Gf.ColorSpaceNames.LinearRec709)


def color_space(attribute: Usd.Attribute) -> Gf.ColorSpace | None:
    """Return the color space of an attribute; None where its colors count as they are, with a warning if unknown."""
    name = Usd.ColorSpaceAPI.ComputeColorSpaceName(attribute, None)
    if name in _AS_THEY_ARE:
        return None
    if Usd.ColorSpaceAPI.IsValidColorSpaceName(attribute.GetPrim(), name, None):
        return Usd.ColorSpaceAPI.ComputeColorSpace(attribute, None)
    for known in (_OTHER_NAMES.get(name, ""), f"{name}_scene"):
        if Gf.ColorSpace.IsValid(known):
            return Gf.ColorSpace(known)
    errors.warn_once(
        f"{attribute.GetPath()}: its color space {name!r} is none that USD knows, so its colors, and others of that "
        "color space, count as linear. Name one such as srgb_rec709_scene or lin_rec709_scene.",
        key=f"color space {name}",
    )
    return None


def is_converted(attribute: Usd.Attribute) -> bool:
    """Return whether an attribute is a color that is not linear Rec. 709."""
    return bool(attribute) and attribute.GetRoleName() == "Color" and color_space(attribute) is not None


def linear_colors(attribute: Usd.Attribute, colors: np.ndarray) -> np.ndarray:
    """Return colors (N, 3) of an attribute as linear Rec. 709, none of them negative if they had to be converted."""
    space = color_space(attribute)
    return colors if space is None else _converted(space, colors)


def current_color(attribute: Usd.Attribute) -> Any:
    """Return `current_value`, with a color as linear Rec. 709."""
    value = current_value(attribute)
    kind = _COLORS.get(type(value))
    if kind is None or attribute.GetRoleName() != "Color" or (space := color_space(attribute)) is None:
        return value
    numbers = list(value)
    return kind(*_converted(space, np.array([numbers[:3]]))[0].tolist(), *numbers[3:])


def refuse_other_space(attribute: Usd.Attribute) -> None:
    """Refuse colors that differ between worlds and are not linear.

    Raises:
        Unsupported: the attribute is a color in another color space.
    """
    if is_converted(attribute):
        name = Usd.ColorSpaceAPI.ComputeColorSpaceName(attribute, None)
        raise errors.Unsupported(
            f"{attribute.GetPath()}: a color in the color space {name} cannot differ between worlds. Author it in "
            "lin_rec709_scene."
        )


def _converted(space: Gf.ColorSpace, colors: np.ndarray) -> np.ndarray:
    colors = np.asarray(colors, np.float64)
    gamma, bias = space.GetGamma(), space.GetLinearBias()
    with np.errstate(over="ignore", invalid="ignore"):
        if gamma != 1.0:
            most, slope = space.GetTransferFunctionParams()
            curved = ((np.maximum(colors, 0.0) + bias) / (1.0 + bias)) ** gamma
            colors = np.where(colors <= most, colors / slope, curved)
        to_rendered = np.linalg.solve(np.array(_RENDERED.GetRGBToXYZ()), np.array(space.GetRGBToXYZ()))
        return np.maximum(colors @ to_rendered.T, 0.0)
