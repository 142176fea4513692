"""Render products, a camera or tiles of several cameras at a resolution, authored as UsdRender prims.

`rep.create.render_product` and `render_product_tiled`.
"""

import math
from typing import Any, overload

from pxr import Gf, Sdf, Usd, UsdGeom, UsdRender

from usdsdg.arguments.prim_names import prim_name
from usdsdg.errors import ArgumentError, BadPrim, RenderError, WrongType, counted
from usdsdg.graph.node import prim_paths
from usdsdg.session import render_products
from usdsdg.session.render_products import HydraTexture, product_at, products, reset
from usdsdg.session.settings.store import get_settings
from usdsdg.session.stage_context import current_stage
from usdsdg.stage import paths
from usdsdg.stage.cameras import default_view
from usdsdg.stage.cameras.stereo_pairs import STEREO_SIDES, stereo_pair
from usdsdg.stage.cameras.tiled_sensors import Tiles, tiles_of_sensor

__all__ = ["HydraTexture", "product_at", "products", "render_product", "render_product_tiled", "reset"]

NAME = "Replicator"
# Number of cameras that an error message lists.
LISTED = 8


@overload
def render_product(
    camera: str, resolution: Any, force_new: bool = False, name: Any = None, render_vars: Any = None
) -> HydraTexture: ...
@overload
def render_product(
    camera: Any, resolution: Any, force_new: bool = False, name: Any = None, render_vars: Any = None
) -> HydraTexture | list[HydraTexture]: ...
def render_product(
    camera: Any, resolution: Any, force_new: bool = False, name: Any = None, render_vars: Any = None
) -> HydraTexture | list[HydraTexture]:
    """Create one render product per camera, below `/Render/HydraTextures` in the session layer.

    The setting `/exts/omni.kit.hydra_texture/renderProduct/path/prefix` may name another place below `/Render`.

    Returns a handle for one camera, a list of handles for several: of a stereo pair the left and the right one.

    Args:
        camera: path, prim or item of a camera, of the object that holds one, or a list of these. One of
            `create.tiled_sensor` gives the image of its cameras in tiles.
        resolution: (width, height) [pixels].
        force_new: create a new product even if one of the same camera and resolution exists. Without this and without
            `name` the existing one is reused.
        name: of the product, or a list with one for each camera; "Replicator" by default, and "Replicator_L" and
            "Replicator_R" of a pair in a prim called StereoCam. A number is appended to a name that is taken;
            characters that a prim name cannot have become underscores.
        render_vars: ignored: annotators and writers determine what is rendered.

    Raises:
        WrongType: resolution is not a pair of integers, which may be texts.
        RenderError: an image of this size is not possible, or it is not the size of the tiled sensor.
        BadPrim: a path is not a camera on the stage, or there is none.
        ArgumentError: the number of names differs from the number of cameras, or the setting is no part of a path.
    """
    size = _size("resolution", resolution)
    cameras = [each for path in prim_paths(camera) for each in _cameras_of(path)]
    names = name if isinstance(name, (list, tuple)) else [name] * len(cameras)
    if not cameras:
        known = _known_cameras()
        raise BadPrim(f"render_product: camera is {camera!r}; give at least one. {known[:1].upper()}{known[1:]}")
    if len(names) != len(cameras):
        raise ArgumentError(
            f"render_product: name has {counted(len(names), 'entry', 'entries')} for "
            f"{counted(len(cameras), 'camera')}; give one for each"
        )
    handles = [
        _product(path, size, force_new, one, default=default)
        for path, one, default in zip(cameras, names, _default_names(cameras))
    ]
    return handles[0] if len(handles) == 1 else handles


def render_product_tiled(
    cameras: Any, tile_resolution: Any, force_new: bool = False, name: str | None = None
) -> HydraTexture:
    """Create one render product that shows several cameras in tiles, row by row from the top left.

    There are ceil(sqrt(N)) columns for N cameras, and as many rows as needed: the product's resolution is columns x
    tile width, rows x tile height. Unused tiles are empty: black with an alpha of 0, infinitely far.

    Per-pixel annotators (colors, depths, normals, motion, segmentation, materials) return the tiled array, in which
    each tile equals the image of its camera alone. Annotators that need one camera, such as boxes and camera_params,
    raise Unsupported at capture.

    Args:
        cameras: paths, prims or items of cameras.
        tile_resolution: (width, height) of each tile.
        force_new: create a new product even if one of the same cameras and resolution exists.
        name: of the product; a named product is always a new one.

    Raises:
        WrongType: tile_resolution is not a pair of integers.
        RenderError: an image of the total size is not possible.
        BadPrim: there are no cameras, or one is not on the stage.
    """
    tile = _size("tile_resolution", tile_resolution)
    paths = tuple(each for path in prim_paths(cameras) for each in _cameras_of(path))
    if not paths:
        raise BadPrim(f"render_product_tiled: no cameras were given; {_known_cameras()}")
    columns = math.ceil(math.sqrt(len(paths)))
    size = _size("the size of all tiles", (columns * tile[0], -(-len(paths) // columns) * tile[1]))
    return _product(paths[0], size, force_new, name, Tiles(paths, tile))


def _size(what: str, resolution: Any) -> tuple[int, int]:
    try:
        width, height = (int(n) for n in resolution)
        if [width, height] != [float(n) for n in resolution]:
            raise ValueError("not whole numbers")
    except (TypeError, ValueError):
        raise WrongType(f"render_product: {what} must be (width, height) in whole pixels, got {resolution!r}") from None
    if problem := render_products.size_problem(width, height):
        raise RenderError(f"render_product: {problem}")
    return width, height


def camera_below(path: str) -> str:
    """Return the path of the first camera at or below `path`, as that of a Replicator camera object.

    Raises:
        BadPrim: there is no such prim, or no camera at or below it.
    """
    prim = current_stage().GetPrimAtPath(path)
    if not prim:
        raise BadPrim(f"render_product: {path} is not on the stage; {_known_cameras()}")
    for candidate in Usd.PrimRange(prim):
        if candidate.IsA(UsdGeom.Camera):
            return str(candidate.GetPath())
    kind = prim.GetTypeName() or "typeless prim"
    raise BadPrim(f"render_product: {path} is a {kind} without a camera in it; {_known_cameras()}")


def _cameras_of(path: str) -> list[str]:
    """Return the paths of both cameras of a stereo pair, else of `camera_below`, whose errors it raises."""
    return stereo_pair(current_stage().GetPrimAtPath(path)) or [camera_below(path)]


def _default_names(cameras: list[str]) -> list[str]:
    """Return the default names of the render products of cameras; those of a stereo pair end in _L and _R."""
    sides = [path[-2:] for path in cameras]
    if sides == list(STEREO_SIDES) and all("StereoCam" in path for path in cameras):
        return [f"{NAME}{side}" for side in sides]
    return [NAME] * len(cameras)


def _prefix() -> str:
    """Return what paths of products begin with, up to their names."""
    given = get_settings().get_as_string(render_products.RP_PREFIX_SETTING) or render_products.LEGACY_RP_PREFIX
    if not Sdf.Path.IsValidPathString(f"/Render/{given}{NAME}"):
        setting = render_products.RP_PREFIX_SETTING
        raise ArgumentError(f"{setting} is {given!r}; expected names, such as 'HydraTextures/'")
    return f"/Render/{given}"


def _known_cameras() -> str:
    found = default_view.cameras(current_stage())
    listed = ", ".join(found[:LISTED]) + (f" and {len(found) - LISTED} more" if len(found) > LISTED else "")
    return f"cameras on the stage: {listed or 'none; rep.create.camera makes one'}"


def _product(
    camera: str,
    size: tuple[int, int],
    force_new: bool,
    name: str | None,
    tiles: Tiles | None = None,
    default: str = NAME,
) -> HydraTexture:
    tiles = tiles or tiles_of_sensor(current_stage().GetPrimAtPath(camera), size)
    if not force_new and name is None:
        for product in products():
            if (product.camera_path, product.resolution, product.tiles) == (camera, size, tiles):
                return product
    stage = current_stage()
    layer = stage.GetEditTarget().GetLayer()
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        path = paths.next_free_path(stage, f"{_prefix()}{prim_name(name) if name else default}")
        prim = UsdRender.Product.Define(stage, path)
        prim.CreateCameraRel().SetTargets([Sdf.Path(each) for each in (tiles.cameras if tiles else [camera])])
        prim.CreateResolutionAttr(Gf.Vec2i(*size))
    return render_products.add(HydraTexture(path, camera, size, tiles=tiles, layer=layer))
