"""Tiled sensors, the deprecated predecessor of tiled render products: `rep.create.tiled_sensor`."""

from collections.abc import Sequence
from typing import Any

from usdsdg.create.cameras import camera
from usdsdg.create.groups import xform
from usdsdg.create.render_products import camera_below
from usdsdg.errors import ArgumentError, warn_once
from usdsdg.graph.node import ReplicatorItem, prim_paths
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.cameras.tiled_sensors import Tiles, author_tiled_sensor

OUTPUT_TYPES = ("rgb", "depth")


def tiled_sensor(
    cameras: Any,
    camera_resolution: Sequence[int],
    tiled_resolution: Sequence[int],
    output_types: Sequence[str] | None = None,
    name: str | None = None,
    parent: Any = None,
) -> ReplicatorItem:
    """Create a camera prim that represents several cameras in tiles; deprecated: use `create.render_product_tiled`.

    Pass it to `create.render_product` with `tiled_resolution`. Per-pixel annotators return the tiled array, row by row
    from the top left; Replicator has only "RtxSensorGpu" for this, whose raw buffer usdsdg does not provide.

    Args:
        cameras: paths, prims or items.
        camera_resolution: (width, height) of each tile.
        tiled_resolution: (width, height) of all tiles, a multiple of `camera_resolution` with room for all cameras.
        output_types: "rgb" (the default) and "depth"; only recorded on the stage. Annotators determine what is
            rendered.
        name: of the camera; "tiled_sensor" by default.
        parent: parent prim of the camera.

    Raises:
        ArgumentError: a resolution is not a multiple, has no room for all cameras, or an output type is unknown.
        BadPrim: a camera is not on the stage.
    """
    warn_once("create.tiled_sensor is deprecated; use create.render_product_tiled(cameras, tile_resolution)")
    types = ["rgb"] if output_types is None else list(output_types)
    if not types or not set(types) <= set(OUTPUT_TYPES):
        raise ArgumentError(f"tiled_sensor: output_types is {types!r}; expected some of {', '.join(OUTPUT_TYPES)}")
    paths = tuple(camera_below(path) for path in prim_paths(cameras))
    (width, height), whole = (int(n) for n in camera_resolution), (int(tiled_resolution[0]), int(tiled_resolution[1]))
    if whole[0] % width or whole[1] % height:
        raise ArgumentError(
            f"tiled_sensor: tiled_resolution {whole} is not a multiple of camera_resolution {(width, height)}"
        )
    if (room := (whole[0] // width) * (whole[1] // height)) < len(paths):
        raise ArgumentError(f"tiled_sensor: tiled_resolution {whole} has room for {room} tiles, not for {len(paths)}")
    sensor = camera(name=name or "tiled_sensor", parent=parent)
    stage = current_stage()
    bridge = stage.GetPrimAtPath(xform().prims[0])
    author_tiled_sensor(
        stage.GetPrimAtPath(camera_below(sensor.prims[0])), bridge, Tiles(paths, (width, height)), whole, types
    )
    return sensor
