"""Tiled sensors: one camera that represents several others, as `rep.create.tiled_sensor` authors it.

The camera refers to a bridge prim, which has the cameras and the sizes.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from pxr import Gf, Sdf, Usd

from usdsdg.errors import RenderError

CONFIG, PLUGIN = "sensorModelConfig", "sensorModelPluginName"
CAMERAS, TILE, WHOLE = "camPrims", "cameraResolution", "tiledResolution"


@dataclass(frozen=True)
class Tiles:
    """Cameras whose images are tiles of one image, row by row from the top left; unused tiles stay empty."""

    cameras: tuple[str, ...]
    size: tuple[int, int]  # width, height of each


def author_tiled_sensor(
    sensor: Usd.Prim, bridge: Usd.Prim, tiles: Tiles, whole: tuple[int, int], output_types: Sequence[str]
) -> None:
    """Make the camera `sensor` represent the cameras of `tiles`, in an image of `whole` pixels."""
    types = Sdf.ValueTypeNames
    sensor.CreateAttribute(CONFIG, types.String).Set(str(bridge.GetPath()))
    sensor.CreateAttribute(PLUGIN, types.String).Set("omni.sensors.tiled.plugin")
    sensor.CreateAttribute("cameraSensorType", types.Token).Set("rtxsensor")
    bridge.CreateRelationship(CAMERAS).SetTargets([Sdf.Path(path) for path in tiles.cameras])
    bridge.CreateAttribute(TILE, types.Int2).Set(Gf.Vec2i(*tiles.size))
    bridge.CreateAttribute(WHOLE, types.Int2).Set(Gf.Vec2i(*whole))
    bridge.CreateAttribute("outputType", types.StringArray).Set(list(output_types))


def tiles_of_sensor(camera: Usd.Prim, size: tuple[int, int]) -> Tiles | None:
    """Return the tiles of a tiled sensor in an image of `size`; None for an ordinary camera.

    Raises:
        RenderError: the sensor makes an image of another size.
    """
    config = camera.GetAttribute(CONFIG).Get() if camera.HasAttribute(CONFIG) else None
    bridge = camera.GetStage().GetPrimAtPath(config) if config else None
    if not bridge or not bridge.HasRelationship(CAMERAS):
        return None
    whole = tuple(bridge.GetAttribute(WHOLE).Get())
    if whole != size:
        raise RenderError(
            f"render_product: {camera.GetPath()} is a tiled sensor of {whole[0]} x {whole[1]} pixels, not "
            f"{size[0]} x {size[1]}; give resolution={whole}"
        )
    cameras = bridge.GetRelationship(CAMERAS).GetTargets()
    return Tiles(tuple(map(str, cameras)), tuple(bridge.GetAttribute(TILE).Get()))
