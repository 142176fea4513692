"""A render product: one camera, one resolution, authored as a UsdRender prim. Mirrors `rep.create.render_product`."""

from __future__ import annotations

from typing import Any

from pxr import Gf, Sdf, Usd, UsdGeom, UsdRender

from usdsdg.errors import BadPrim
from usdsdg.graph.node import prim_paths
from usdsdg.stage import paths
from usdsdg.stage.context import current_stage

PREFIX = "/Render/HydraTextures"


class HydraTexture:
    """The handle that Replicator scripts get: its own `hydra_texture`, to be switched on and off between captures."""

    def __init__(self, path: str, camera_path: str, resolution: tuple[int, int]) -> None:
        self.path = path
        self.camera_path = camera_path
        self.resolution = resolution
        self.updates_enabled = True

    @property
    def name(self) -> str:
        """Last part of the path: names folders and payload keys."""
        return self.path.rsplit("/", 1)[-1]

    @property
    def width(self) -> int:
        return self.resolution[0]

    @property
    def height(self) -> int:
        return self.resolution[1]

    @property
    def hydra_texture(self) -> HydraTexture:
        return self

    def set_updates_enabled(self, enabled: bool) -> None:
        """A product that is switched off yields no frames."""
        self.updates_enabled = bool(enabled)

    def get_render_product_path(self) -> str:
        return self.path

    def destroy(self) -> None:
        """Forget the product; writers attached to it no longer see it."""
        _products.pop(self.path, None)

    def __repr__(self) -> str:
        return f"HydraTexture({self.path!r}, camera={self.camera_path!r}, resolution={self.resolution})"


_products: dict[str, HydraTexture] = {}


def products() -> list[HydraTexture]:
    """All render products of the current stage, oldest first."""
    return list(_products.values())


def product_at(path: str) -> HydraTexture:
    """The product with prim path `path`.

    Raises:
        BadPrim: there is none; the message lists those that exist.
    """
    if path not in _products:
        raise BadPrim(f"no render product {path}; there are: {', '.join(_products) or 'none'}")
    return _products[path]


def reset() -> None:
    """A new stage has no products."""
    _products.clear()


def render_product(
    camera: Any, resolution: Any, force_new: bool = False, name: Any = None, render_vars: Any = None
) -> HydraTexture | list[HydraTexture]:
    """One product per camera: a handle for one, a list for several.

    `camera` is a path, prim, item, or a list of these; `resolution` is (width, height). A product of the same camera
    and resolution is used again unless `force_new` or `name` is given.

    Raises:
        TypeError: resolution is not a pair of whole numbers.
        BadPrim: a camera path is not a camera on the stage.
    """
    size = _size(resolution)
    cameras = [_camera_below(path) for path in prim_paths(camera)]
    names = name if isinstance(name, (list, tuple)) else [name] * len(cameras)
    handles = [_product(path, size, force_new, one) for path, one in zip(cameras, names)]
    return handles[0] if len(handles) == 1 else handles


def _size(resolution: Any) -> tuple[int, int]:
    try:
        width, height = (int(n) for n in resolution)
    except (TypeError, ValueError):
        raise TypeError(f"render_product: resolution must be (width, height), got {resolution!r}") from None
    if width < 1 or height < 1:
        raise TypeError(f"render_product: resolution must be at least 1x1, got {resolution!r}")
    return width, height


def _camera_below(path: str) -> str:
    """The camera itself, or the one camera that a Replicator camera object holds."""
    prim = current_stage().GetPrimAtPath(path)
    if not prim:
        raise BadPrim(f"render_product: {path} is not on the stage")
    for candidate in Usd.PrimRange(prim):
        if candidate.IsA(UsdGeom.Camera):
            return str(candidate.GetPath())
    raise BadPrim(f"render_product: {path} is a {prim.GetTypeName() or 'typeless prim'}, not a camera")


def _product(camera: str, size: tuple[int, int], force_new: bool, name: str | None) -> HydraTexture:
    if not force_new and name is None:
        for product in _products.values():
            if (product.camera_path, product.resolution) == (camera, size):
                return product
    stage = current_stage()
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        path = paths.next_free_path(stage, f"{PREFIX}/{name or 'Replicator'}")
        prim = UsdRender.Product.Define(stage, path)
        prim.CreateCameraRel().SetTargets([Sdf.Path(camera)])
        prim.CreateResolutionAttr(Gf.Vec2i(*size))
    product = HydraTexture(path, camera, size)
    _products[path] = product
    return product
