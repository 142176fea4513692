"""UsdLux lights.

`intensity` is in nits (of a distant light: lux), doubled by each unit of `exposure`; `color` and `shaping_focus_tint`
are linear RGB, `color_temperature` is in kelvin and counts when `enable_color_temperature` is True.
`shaping_cone_angle` is half the opening of the beam in degrees (180: no cone), `shaping_cone_softness` 0 to 1. Sizes
are in stage units. All of them may be lists with one value per light.
"""

from typing import Any

from pxr import Gf, Sdf, Usd, UsdLux

from usdsdg.arguments.values import shown
from usdsdg.errors import ArgumentError
from usdsdg.functional.arguments import per_prim, vectors
from usdsdg.functional.new_prims import apply_common_arguments, define, new_paths, numbers
from usdsdg.stage.attributes import asset_path

_T = Sdf.ValueTypeNames
_NUMBERS = {
    "intensity": "inputs:intensity",
    "exposure": "inputs:exposure",
    "color_temperature": "inputs:colorTemperature",
    "diffuse": "inputs:diffuse",
    "specular": "inputs:specular",
    "shaping_cone_angle": "inputs:shaping:cone:angle",
    "shaping_cone_softness": "inputs:shaping:cone:softness",
    "radius": "inputs:radius",
    "height": "inputs:height",
    "width": "inputs:width",
    "length": "inputs:length",
    "angle": "inputs:angle",
}
_COLORS = {"color": "inputs:color", "shaping_focus_tint": "inputs:shaping:focusTint"}
_TEXTURE_FORMATS = ("automatic", "latlong", "mirroredBall", "angular", "cubeMapVerticalCross")


def _lights(kind: str, arguments: dict[str, Any]) -> list[Usd.Prim]:
    count = arguments.pop("count")
    prims = define(new_paths(arguments.pop("name") or kind, arguments.pop("parent"), count), kind)
    if "shaping_cone_angle" in arguments:
        for prim in prims:
            UsdLux.ShapingAPI.Apply(prim)
    for name in [name for name in arguments if name in _NUMBERS]:
        for prim, value in zip(prims, numbers(name, arguments.pop(name), len(prims)) or ()):
            prim.CreateAttribute(_NUMBERS[name], _T.Float, custom=False).Set(value)
    for name in [name for name in arguments if name in _COLORS]:
        for prim, value in zip(prims, vectors(name, arguments.pop(name), len(prims)).tolist()):
            prim.CreateAttribute(_COLORS[name], _T.Color3f, custom=False).Set(Gf.Vec3f(*value))
    for prim, enabled in zip(prims, per_prim(arguments.pop("enable_color_temperature"), len(prims))):
        UsdLux.LightAPI(prim).CreateEnableColorTemperatureAttr(bool(enabled))
    return apply_common_arguments(prims, **arguments)


def dome_light(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    color: Any = (1.0, 1.0, 1.0), texture: Any = None, texture_format: Any = "latlong", intensity: Any = 1000.0,
    exposure: Any = 1.0, diffuse: Any = 1.0, specular: Any = 1.0, color_temperature: Any = 6500,
    enable_color_temperature: Any = False, count: int = 1, name: str | None = None, parent: Any = None,
) -> list[Usd.Prim]:  # fmt: skip
    """Environment lights, optionally with the image `texture` (a file or a URL below the assets root).

    Raises:
        AssetNotFound: there is no such image.
        ArgumentError: `texture_format` is not one of USD's.
    """
    arguments = dict(locals())
    # Checked before any prim is made.
    files = [None if each is None else asset_path(each) for each in per_prim(arguments.pop("texture"), count)]
    formats = per_prim(arguments.pop("texture_format"), count)
    if unknown := [each for each in formats if each not in _TEXTURE_FORMATS]:
        raise ArgumentError(f"texture_format is {shown(unknown[0])}; expected one of {', '.join(_TEXTURE_FORMATS)}")
    prims = _lights("DomeLight", arguments)
    for prim, file, layout in zip(prims, files, formats):
        light = UsdLux.DomeLight(prim)
        light.CreateTextureFormatAttr(layout)
        if file is not None:
            light.CreateTextureFileAttr(file)
    return prims


def sphere_light(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True,
    color: Any = (1.0, 1.0, 1.0), intensity: Any = 30000.0, exposure: Any = None, color_temperature: Any = 6500,
    enable_color_temperature: Any = False, diffuse: Any = 1.0, specular: Any = 1.0, shaping_cone_angle: Any = 180.0,
    shaping_cone_softness: Any = 0.0, shaping_focus_tint: Any = (1.0, 1.0, 1.0), radius: Any = 1.0,
    count: int = 1, name: str | None = None, parent: Any = None,
) -> list[Usd.Prim]:  # fmt: skip
    """Lights that emit from the surfaces of spheres."""
    return _lights("SphereLight", locals())


def disk_light(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True,
    color: Any = (1.0, 1.0, 1.0), intensity: Any = 30000.0, exposure: Any = None, color_temperature: Any = 6500,
    enable_color_temperature: Any = False, diffuse: Any = 1.0, specular: Any = 1.0, shaping_cone_angle: Any = 180.0,
    shaping_cone_softness: Any = 0.0, shaping_focus_tint: Any = (1.0, 1.0, 1.0), radius: Any = 1.0,
    count: int = 1, name: str | None = None, parent: Any = None,
) -> list[Usd.Prim]:  # fmt: skip
    """Lights that emit from disks, toward -Z."""
    return _lights("DiskLight", locals())


def rect_light(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True,
    color: Any = (1.0, 1.0, 1.0), intensity: Any = 30000.0, exposure: Any = None, color_temperature: Any = 6500,
    enable_color_temperature: Any = False, diffuse: Any = 1.0, specular: Any = 1.0, shaping_cone_angle: Any = 180.0,
    shaping_cone_softness: Any = 0.0, shaping_focus_tint: Any = (1.0, 1.0, 1.0), height: Any = 1.0, width: Any = 1.0,
    count: int = 1, name: str | None = None, parent: Any = None,
) -> list[Usd.Prim]:  # fmt: skip
    """Lights that emit from rectangles in the xy plane, toward -Z."""
    return _lights("RectLight", locals())


def cylinder_light(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True,
    color: Any = (1.0, 1.0, 1.0), intensity: Any = 30000.0, exposure: Any = None, color_temperature: Any = 6500,
    enable_color_temperature: Any = False, diffuse: Any = 1.0, specular: Any = 1.0, shaping_cone_angle: Any = 180.0,
    shaping_cone_softness: Any = 0.0, shaping_focus_tint: Any = (1.0, 1.0, 1.0), radius: Any = 1.0, length: Any = 1.0,
    count: int = 1, name: str | None = None, parent: Any = None,
) -> list[Usd.Prim]:  # fmt: skip
    """Lights that emit from cylinders along x."""
    return _lights("CylinderLight", locals())


def distant_light(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True,
    color: Any = (1.0, 1.0, 1.0), intensity: Any = 30000.0, exposure: Any = None, color_temperature: Any = 6500,
    enable_color_temperature: Any = False, diffuse: Any = 1.0, specular: Any = 1.0, shaping_cone_angle: Any = 180.0,
    shaping_cone_softness: Any = 0.0, shaping_focus_tint: Any = (1.0, 1.0, 1.0), angle: Any = 1.0,
    count: int = 1, name: str | None = None, parent: Any = None,
) -> list[Usd.Prim]:  # fmt: skip
    """Distant lights toward -Z with an angular diameter of `angle` degrees."""
    return _lights("DistantLight", locals())
