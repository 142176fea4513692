"""`ViewportManager`: cameras and resolutions of render products and of the viewport, which has no window."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdRender

from usdsdg.compat.omni.kit.viewport.utility import Viewport, get_active_viewport
from usdsdg.compat.wrappers.cameras import aim, camera_at
from usdsdg.compat.wrappers.prim_paths import prim_of
from usdsdg.compat.wrappers.unsupported import refused_function
from usdsdg.errors import BadPrim, warn_once

Target = str | Sdf.Path | Usd.Prim | UsdRender.Product | Viewport | None
_INTEREST = "omni:kit:centerOfInterest"
_VIEWPORT = "Viewport"
_NO_WINDOW = "there are no viewport windows; make a render product with rep.create.render_product"


class ViewportManager:
    """Class methods only; None as a target is the viewport."""

    @classmethod
    def set_camera_view(
        cls,
        camera: str | Usd.Prim | UsdGeom.Camera,
        *,
        eye: Sequence[float] | np.ndarray | None = None,
        target: Sequence[float] | np.ndarray | None = None,
        relative_tracking: bool = False,
    ) -> None:
        """Move a camera to `eye` and point it at `target`, both (3,) in the world [stage units].

        Without a target it looks at its center of interest if it has one, else it keeps its orientation. A target
        becomes the center of interest of a camera that has one. With `relative_tracking` and no eye the camera moves
        as far as the target is from the center of interest, and looks at the target from there. A camera that looks
        straight down has +X at the top of the image, and one that looks straight up -X, as in Isaac Sim.

        Raises:
            BadPrim: there is no such camera.
            DegenerateFrame: the camera is at its target.
        """
        prim = camera_at(camera.GetPrim() if isinstance(camera, UsdGeom.Camera) else camera)
        interest = _interest(prim)
        if eye is None and target is None and interest is None:
            warn_once(f"set_camera_view: {prim.GetPath()} stays, since neither eye nor target are given")
            return
        if target is not None and interest is not None and eye is None and relative_tracking:
            position = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim).ExtractTranslation())
            eye = position + np.asarray(target, float) - interest
        where = interest if target is None else target
        aim(prim, eye, where, top_of_vertical=lambda upward: (-1.0 if upward else 1.0, 0.0, 0.0))
        if target is not None and interest is not None:
            prim.GetAttribute(_INTEREST).Set(Gf.Vec3d(*np.asarray(target, float).tolist()))

    # --- cameras and resolutions ---
    @classmethod
    def set_camera(cls, camera: str | Usd.Prim, *, render_product_or_viewport: Target = None) -> None:
        """Set the camera of a render product or of the viewport.

        Raises:
            BadPrim: there is no such camera or render product.
        """
        path = str(camera_at(camera).GetPath())
        product = _product("set the camera", render_product_or_viewport)
        if product is None:
            get_active_viewport().set_active_camera(path)
        else:
            with _session_layer(product):
                product.CreateCameraRel().SetTargets([path])

    @classmethod
    def get_camera(cls, render_product_or_viewport: Target = None) -> UsdGeom.Camera:
        """Return the camera of a render product or of the viewport.

        Raises:
            BadPrim: there is no such camera or render product.
        """
        product = _product("get the camera", render_product_or_viewport)
        targets = [get_active_viewport().camera_path] if product is None else product.GetCameraRel().GetTargets()
        return UsdGeom.Camera(camera_at(str(targets[0]) if targets else ""))

    @classmethod
    def set_resolution(cls, resolution: tuple[int, int], *, render_product_or_viewport: Target = None) -> None:
        """Set (width, height) [pixels] of a render product or of the viewport.

        Raises:
            BadPrim: there is no such render product.
        """
        product = _product("set the resolution", render_product_or_viewport)
        if product is None:
            get_active_viewport().resolution = (int(resolution[0]), int(resolution[1]))
        else:
            with _session_layer(product):
                product.CreateResolutionAttr().Set(Gf.Vec2i(*(int(each) for each in resolution)))

    @classmethod
    def get_resolution(cls, render_product_or_viewport: Target = None) -> tuple[int, int]:
        """Return (width, height) [pixels] of a render product or of the viewport.

        Raises:
            BadPrim: there is no such render product.
        """
        product = _product("get the resolution", render_product_or_viewport)
        return get_active_viewport().resolution if product is None else tuple(product.GetResolutionAttr().Get())

    @classmethod
    def get_render_product(cls, render_product_or_viewport: Target = None) -> UsdRender.Product | None:
        """Return the render product of a path or prim, or of the viewport; None where there is none."""
        if _is_viewport(render_product_or_viewport):
            return UsdRender.Product(prim_of(get_active_viewport().render_product_path))
        return _found_product(render_product_or_viewport)

    @classmethod
    def get_viewport_api(cls, render_product_or_viewport: Target = None) -> Viewport | None:
        """Return the viewport; None for anything else."""
        return get_active_viewport() if _is_viewport(render_product_or_viewport) else None

    # --- windows ---
    @classmethod
    def wait_for_viewport(
        cls, *, viewport: str | Viewport | None = None, max_frames: int = 60, sleep_time: float = 0.02
    ) -> tuple[bool, int]:
        """Return (True, 0): there is nothing to wait for."""
        return True, 0

    @classmethod
    async def wait_for_viewport_async(
        cls, *, viewport: str | Viewport | None = None, max_frames: int = 60, sleep_time: float = 0.02
    ) -> tuple[bool, int]:
        """Return (True, 0): there is nothing to wait for."""
        return True, 0

    @classmethod
    def get_viewport_windows(cls, *, include: Sequence[str] = (), exclude: Sequence[str] = ()) -> list[object]:
        """Return []: there are no windows."""
        return []

    @classmethod
    def destroy_viewport_windows(cls, *, include: Sequence[str] = (), exclude: Sequence[str] = ()) -> list[str]:
        """Return []: there are no windows to close."""
        return []

    create_viewport_window = staticmethod(refused_function("ViewportManager.create_viewport_window", _NO_WINDOW))


def _is_viewport(target: Target) -> bool:
    return target is None or isinstance(target, Viewport) or target == _VIEWPORT


def _found_product(target: Target) -> UsdRender.Product | None:
    prim = prim_of(target) if Sdf.Path.IsValidPathString(str(target)) or not isinstance(target, str) else None
    return UsdRender.Product(prim) if prim and prim.IsA(UsdRender.Product) else None


def _product(wanted: str, target: Target) -> UsdRender.Product | None:
    """Return the render product; None for the viewport."""
    if _is_viewport(target):
        return None
    found = _found_product(target)
    if found is None:
        raise BadPrim(
            f"ViewportManager cannot {wanted}: {target} is no render product; give the path of one, or "
            f"{_VIEWPORT!r} or None for the viewport"
        )
    return found


def _session_layer(product: UsdRender.Product) -> Usd.EditContext:
    """Let edits inside the block count, wherever the product was made: those of Replicator are in the session layer."""
    stage = product.GetPrim().GetStage()
    return Usd.EditContext(stage, stage.GetSessionLayer())


def _interest(camera: Usd.Prim) -> np.ndarray | None:
    """Return the center of interest (3,) of a camera, which Isaac Sim has in the world; None if it has none."""
    value = camera.GetAttribute(_INTEREST).Get() if camera.HasAttribute(_INTEREST) else None
    if value is None:
        return None
    return np.array(value)
