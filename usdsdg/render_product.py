"""A render product: one camera, one resolution, authored as a UsdRender prim. Mirrors `rep.create.render_product`."""

from __future__ import annotations

from typing import Any

from pxr import Gf, Sdf, Usd, UsdGeom, UsdRender

from usdsdg.errors import BadPrim, RenderError
from usdsdg.graph.node import prim_paths
from usdsdg.stage import default_view, paths, render_products
from usdsdg.stage.context import current_stage
from usdsdg.stage.render_products import HydraTexture, product_at, products, reset

__all__ = ["HydraTexture", "product_at", "products", "render_product", "reset"]

PREFIX = "/Render/HydraTextures"
# Cameras that an error lists.
LISTED = 8


def render_product(
    camera: Any, resolution: Any, force_new: bool = False, name: Any = None, render_vars: Any = None
) -> HydraTexture | list[HydraTexture]:
    """One product per camera: a handle for one, a list for several.

    `camera` is a path, prim, item, or a list of these; `resolution` is (width, height). A product of the same camera
    and resolution is used again unless `force_new` or `name` is given. `render_vars` changes nothing: what is rendered
    is what annotators and writers read.

    Raises:
        TypeError: resolution is not a pair of whole numbers.
        RenderError: a picture of this size cannot be made.
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
    if problem := render_products.size_problem(width, height):
        raise RenderError(f"render_product: {problem}")
    return width, height


def _camera_below(path: str) -> str:
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


def _product(camera: str, size: tuple[int, int], force_new: bool, name: str | None) -> HydraTexture:
    if not force_new and name is None:
        for product in products():
            if (product.camera_path, product.resolution) == (camera, size):
                return product
    stage = current_stage()
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        path = paths.next_free_path(stage, f"{PREFIX}/{name or 'Replicator'}")
        prim = UsdRender.Product.Define(stage, path)
        prim.CreateCameraRel().SetTargets([Sdf.Path(camera)])
        prim.CreateResolutionAttr(Gf.Vec2i(*size))
    return render_products.add(HydraTexture(path, camera, size))
