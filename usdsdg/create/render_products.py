"""A render product: a camera, or several in tiles, and a resolution, authored as a UsdRender prim.

Mirrors `rep.create.render_product` and `render_product_tiled`.
"""

import math
from typing import Any

from pxr import Gf, Sdf, Usd, UsdGeom, UsdRender

from usdsdg.errors import ArgumentError, BadPrim, RenderError
from usdsdg.graph.node import prim_paths
from usdsdg.session import render_products
from usdsdg.session.render_products import HydraTexture, product_at, products, reset
from usdsdg.session.stage_context import current_stage
from usdsdg.stage import paths
from usdsdg.stage.cameras import default_view
from usdsdg.stage.cameras.tiled_sensors import Tiles, tiles_of_sensor

__all__ = ["HydraTexture", "product_at", "products", "render_product", "render_product_tiled", "reset"]

PREFIX = "/Render/HydraTextures"
# Cameras that an error lists.
LISTED = 8


def render_product(
    camera: Any, resolution: Any, force_new: bool = False, name: Any = None, render_vars: Any = None
) -> HydraTexture | list[HydraTexture]:
    """One product per camera, below `/Render/HydraTextures` in the session layer: a handle for one, a list for several.

    Args:
        camera: path, prim or item of a camera, of the object that holds one, or a list of these. One of
            `create.tiled_sensor` gives the image of its cameras in tiles.
        resolution: (width, height) [pixels].
        force_new: make another one, also where there is a product of the same camera and resolution. Without this and
            without `name` that one is used again.
        name: of the product, or a list with one for each camera; "Replicator" by default. A name that is taken gets a
            number.
        render_vars: changes nothing: what is rendered is what annotators and writers read.

    Raises:
        TypeError: resolution is not a pair of whole numbers.
        RenderError: an image of this size cannot be made, or it is not that of the tiled sensor.
        BadPrim: a path is not a camera on the stage, there is none, or `name` cannot be the name of a prim.
        ArgumentError: there is another number of names than cameras.
    """
    size = _size("resolution", resolution)
    cameras = [camera_below(path) for path in prim_paths(camera)]
    names = name if isinstance(name, (list, tuple)) else [name] * len(cameras)
    if not cameras:
        raise BadPrim(f"render_product: camera is {camera!r}; give at least one. {_cameras_there_are().capitalize()}")
    if len(names) != len(cameras):
        raise ArgumentError(
            f"render_product: name has {len(names)} entries for {len(cameras)} cameras; give one for each"
        )
    handles = [_product(path, size, force_new, one) for path, one in zip(cameras, names)]
    return handles[0] if len(handles) == 1 else handles


def render_product_tiled(
    cameras: Any, tile_resolution: Any, force_new: bool = False, name: str | None = None
) -> HydraTexture:
    """One product with the images of several cameras in tiles, row by row from the top left.

    There are ceil(sqrt(N)) columns for N cameras, and as many rows as it takes: the product's resolution is columns x
    tile width, rows x tile height. Places that are left over show nothing: black with an alpha of 0, infinitely far.

    Annotators that work pixel by pixel (colors, depths, normals, motion, segmentation, materials) give the tiled
    array, in which each tile is what its camera alone gives. Those that need one camera, such as boxes and
    camera_params, raise Unsupported at the capture.

    Args:
        cameras: paths, prims or items of cameras.
        tile_resolution: (width, height) of each tile.
        force_new: Make a product also where there is one of the same cameras and resolution.
        name: of the product, which is then a new one.

    Raises:
        TypeError: tile_resolution is not a pair of whole numbers.
        RenderError: an image of the whole size cannot be made.
        BadPrim: there are no cameras, or one is not on the stage.
    """
    tile = _size("tile_resolution", tile_resolution)
    paths = tuple(camera_below(path) for path in prim_paths(cameras))
    if not paths:
        raise BadPrim(f"render_product_tiled: no cameras were given; {_cameras_there_are()}")
    columns = math.ceil(math.sqrt(len(paths)))
    size = _size("the size of all tiles", (columns * tile[0], -(-len(paths) // columns) * tile[1]))
    return _product(paths[0], size, force_new, name, Tiles(paths, tile))


def _size(what: str, resolution: Any) -> tuple[int, int]:
    try:
        width, height = (int(n) for n in resolution)
        if (width, height) != tuple(resolution):
            raise ValueError("not whole numbers")
    except (TypeError, ValueError):
        raise TypeError(f"render_product: {what} must be (width, height) in whole pixels, got {resolution!r}") from None
    if problem := render_products.size_problem(width, height):
        raise RenderError(f"render_product: {problem}")
    return width, height


def camera_below(path: str) -> str:
    """The camera itself, or the one camera that a Replicator camera object holds."""
    prim = current_stage().GetPrimAtPath(path)
    if not prim:
        raise BadPrim(f"render_product: {path} is not on the stage; {_cameras_there_are()}")
    for candidate in Usd.PrimRange(prim):
        if candidate.IsA(UsdGeom.Camera):
            return str(candidate.GetPath())
    kind = prim.GetTypeName() or "typeless prim"
    raise BadPrim(f"render_product: {path} is a {kind} without a camera in it; {_cameras_there_are()}")


def _cameras_there_are() -> str:
    found = default_view.cameras(current_stage())
    listed = ", ".join(found[:LISTED]) + (f" and {len(found) - LISTED} more" if len(found) > LISTED else "")
    return f"cameras on the stage: {listed or 'none'}"


def _product(
    camera: str, size: tuple[int, int], force_new: bool, name: str | None, tiles: Tiles | None = None
) -> HydraTexture:
    tiles = tiles or tiles_of_sensor(current_stage().GetPrimAtPath(camera), size)
    if not force_new and name is None:
        for product in products():
            if (product.camera_path, product.resolution, product.tiles) == (camera, size, tiles):
                return product
    stage = current_stage()
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        path = paths.next_free_path(stage, f"{PREFIX}/{name or 'Replicator'}")
        prim = UsdRender.Product.Define(stage, path)
        prim.CreateCameraRel().SetTargets([Sdf.Path(each) for each in (tiles.cameras if tiles else [camera])])
        prim.CreateResolutionAttr(Gf.Vec2i(*size))
    return render_products.add(HydraTexture(path, camera, size, tiles=tiles))
