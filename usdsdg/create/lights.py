"""UsdLux lights: `rep.create.light`."""

from typing import Any

from pxr import Usd, UsdLux

from usdsdg import modify
from usdsdg.arguments.prims import prim_at
from usdsdg.create.objects import create_objects
from usdsdg.errors import ArgumentError
from usdsdg.graph.node import ReplicatorItem

LIGHT_SCHEMAS = {
    "cylinder": UsdLux.CylinderLight,
    "disk": UsdLux.DiskLight,
    "distant": UsdLux.DistantLight,
    "dome": UsdLux.DomeLight,
    "rect": UsdLux.RectLight,
    "sphere": UsdLux.SphereLight,
}

_TEXTURED = (UsdLux.DomeLight, UsdLux.RectLight)


def light(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    light_type: str = "Distant", color: Any = (1.0, 1.0, 1.0), intensity: Any = 1000.0, exposure: Any = None,
    temperature: Any = 6500, texture: Any = None, count: int = 1, name: str | None = None, parent: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Create UsdLux lights: cylinder, disk, distant, dome, rect or sphere (any case).

    The prims are created once, when this line runs; arguments that are distributions are sampled again at every firing
    of the enclosing trigger.

    Args:
        position: in the space of `parent` [stage units]; `scale` are factors and `rotation` angles [degrees].
        look_at: a point of the world [stage units] or prims, to which the light shines.
        color: linear RGB.
        intensity: nits (of a distant light: lux), doubled by each unit of `exposure`.
        temperature: kelvin; None disables color temperature.
        texture: image of a dome or rect light, a file or a URL below the assets root.

    Raises:
        ArgumentError: an unknown light_type, or a texture for a light that has none.
        AssetNotFound: there is no such texture; the message names near misses.
    """
    schema = LIGHT_SCHEMAS.get(str(light_type).lower())
    if schema is None:
        raise ArgumentError(f"create.light: light_type={light_type!r}; known: {', '.join(LIGHT_SCHEMAS)}")
    if texture is not None and schema not in _TEXTURED:
        raise ArgumentError(f"create.light: a {light_type} light has no texture; give it to a dome or rect light")

    def define(stage: Usd.Stage, path: str) -> None:
        UsdLux.LightAPI(schema.Define(stage, path)).CreateEnableColorTemperatureAttr(temperature is not None)

    item = create_objects(
        f"{light_type.capitalize()}Light", define, position=position, scale=scale, rotation=rotation, look_at=look_at,
        look_at_up_axis=look_at_up_axis, node="OgnCreateLight", name=name, parent=parent, count=count,
    )  # fmt: skip
    lights = [prim_at(path).GetChildren()[0] for path in item.prims]
    values = {
        "inputs:color": color,
        "inputs:intensity": intensity,
        "inputs:exposure": exposure,
        "inputs:colorTemperature": temperature,
        "inputs:texture:file": texture,
    }
    for attribute, value in values.items():
        if value is not None:
            modify.apply_or_schedule(attribute, value, lights)
    return item
