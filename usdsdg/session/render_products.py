"""The render products of the current stage, by prim path."""

from __future__ import annotations

import difflib
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from pxr import Gf, Sdf, Usd, UsdGeom, UsdRender

from usdsdg import errors
from usdsdg.session.session import current
from usdsdg.session.turns import in_turn
from usdsdg.stage.cameras.tiled_sensors import Tiles

# Limits of the renderer and of file formats: the longest side, and a few hundred bytes of memory for each pixel.
MAX_SIDE, MAX_PIXELS = 16384, 1 << 26
# The setting of what stands between `/Render/` and the name of a product in its path, and what does where it is empty.
RP_PREFIX_SETTING = "/exts/omni.kit.hydra_texture/renderProduct/path/prefix"
LEGACY_RP_PREFIX = "RenderProduct_"


def size_problem(width: int, height: int) -> str | None:
    """Return why an image of this size cannot be rendered, or None if it can."""
    if min(width, height) >= 1 and max(width, height) <= MAX_SIDE and width * height <= MAX_PIXELS:
        return None
    return (
        f"an image of {width} x {height} pixels cannot be made; expected 1 to {MAX_SIDE} along each side and no more "
        f"than {MAX_PIXELS} in all, such as 8192 x 8192"
    )


class HydraTexture:
    """A render product: a camera, or several in tiles, and a resolution, with updates on or off.

    `tiles` is None for the image of one camera; otherwise `camera_path` is that of the first tile. Camera and
    resolution are those of the prim, also where a script writes its relationship or its attribute. `layer` is the one
    that the script edited when it made the product.
    """

    def __init__(
        self,
        path: str,
        camera_path: str,
        resolution: tuple[int, int],
        *,
        tiles: Tiles | None = None,
        layer: Sdf.Layer | None = None,
    ) -> None:
        self.path = path
        self.layer = layer
        self._camera_path = camera_path
        self._resolution = resolution
        self.tiles = tiles
        self.updates_enabled = True
        # False: annotators alone do not cause captures of a playing timeline; they are computed when they are read.
        self.captured_on_play = True

    @property
    def name(self) -> str:
        """The last element of the path, used as folder name and payload key."""
        return self.path.rsplit("/", 1)[-1]

    @property
    def camera_path(self) -> str:
        """The path of the camera that it shows."""
        prim = None if self.tiles else self._prim()
        targets = UsdRender.Product(prim).GetCameraRel().GetForwardedTargets() if prim else []
        return str(targets[0]) if targets else self._camera_path

    def shown(self) -> tuple[tuple[str, tuple[int, int]], bool]:
        """Return camera and resolution, and whether they stay so until the prim of the product changes."""
        prim = None if self.tiles else self._prim()
        camera = UsdRender.Product(prim).GetCameraRel() if prim else None
        # A target that is a property leads on to those of another relationship.
        stays = camera is not None and all(target.IsPrimPath() for target in camera.GetTargets())
        return (self.camera_path, self.resolution), stays

    @property
    def resolution(self) -> tuple[int, int]:
        """Width and height of its images [pixels]; setting it is `set_resolution`.

        Raises:
            RenderError: the prim has a size of which no image is possible.
        """
        prim = None if self.tiles else self._prim()
        attribute = UsdRender.Product(prim).GetResolutionAttr() if prim else None
        if not attribute or not attribute.HasAuthoredValue():
            return self._resolution
        return self._possible(attribute.Get())

    @resolution.setter
    def resolution(self, resolution: Sequence[int]) -> None:
        self.set_resolution(resolution)

    @property
    def width(self) -> int:
        """Width of its images [pixels]."""
        return self.resolution[0]

    @property
    def height(self) -> int:
        """Height of its images [pixels]."""
        return self.resolution[1]

    @property
    def hydra_texture(self) -> HydraTexture:
        """The product itself, which in Replicator is an object of its own."""
        return self

    def set_updates_enabled(self, enabled: bool) -> None:
        """Turn captures of this product on or off."""
        self.updates_enabled = bool(enabled)

    def set_camera(self, path: str) -> None:
        """Show the camera at `path` from now on.

        Raises:
            BadPrim: there is no such prim, or it is not a camera.
        """
        stage = current().stage
        prim = stage.GetPrimAtPath(path) if stage else None
        if not prim or not prim.IsA(UsdGeom.Camera):
            raise errors.BadPrim(f"{self.path}: {path} is not a camera on the stage")
        self._camera_path = path
        if self._prim():
            with self._editing() as product:
                product.CreateCameraRel().SetTargets([path])

    def set_camera_path(self, path: str) -> None:
        """As `set_camera`."""
        self.set_camera(path)

    def set_width(self, width: int) -> None:
        """Set the width [pixels] from now on; errors as of `set_resolution`."""
        self.set_resolution((width, self.height))

    def set_height(self, height: int) -> None:
        """Set the height [pixels] from now on; errors as of `set_resolution`."""
        self.set_resolution((self.width, height))

    def set_resolution(self, resolution: Sequence[int]) -> None:
        """Set width and height [pixels] from now on.

        Raises:
            RenderError: an image of this size is not possible.
        """
        self._resolution = self._possible(resolution)
        if self._prim():
            with self._editing() as product:
                product.CreateResolutionAttr().Set(Gf.Vec2i(*self._resolution))

    def _possible(self, resolution: Sequence[int]) -> tuple[int, int]:
        width, height = int(resolution[0]), int(resolution[1])
        if problem := size_problem(width, height):
            raise errors.RenderError(f"{self.path}: {problem}")
        return width, height

    def _prim(self) -> Usd.Prim | None:
        """Return its prim; None where it is no product of the current stage, of which another may have its path."""
        state = current()
        if state.stage is None or state.render_products.get(self.path) is not self:
            return None
        return state.stage.GetPrimAtPath(self.path) or None

    @contextmanager
    def _editing(self) -> Iterator[UsdRender.Product]:
        """Yield its prim, for edits of the session layer."""
        stage = current().stage
        assert stage is not None
        with Usd.EditContext(stage, stage.GetSessionLayer()):
            yield UsdRender.Product(stage.GetPrimAtPath(self.path))

    def get_render_product_path(self) -> str:
        """Return the path of its UsdRender prim, which is in the session layer."""
        return self.path

    def get_name(self) -> str:
        """Return `name`."""
        return self.name

    def get_camera_path(self) -> str:
        """Return `camera_path`."""
        return self.camera_path

    def get_width(self) -> int:
        """Return `width`."""
        return self.width

    def get_height(self) -> int:
        """Return `height`."""
        return self.height

    @property
    def hydra_engine(self) -> str:
        """Always "rtx", the renderer that scripts ask for."""
        return "rtx"

    @in_turn
    def destroy(self) -> None:
        """Remove the product and its prim; attached writers and annotators receive no more frames of it.

        While one of them is attached the prim stays, so that no other product gets its path, and with it them. A
        product of an earlier stage leaves one at the same path in the current stage as it is.
        """
        prim = self._prim()
        self.forget()
        # Finalizers of scripts' objects call this, and run on any thread; only the main one edits the stage.
        if prim is not None and not self._is_read() and threading.current_thread() is threading.main_thread():
            stage = prim.GetStage()
            with Usd.EditContext(stage, stage.GetSessionLayer()):
                stage.RemovePrim(prim.GetPath())

    def forget(self) -> None:
        """Remove the product and leave its prim, as finalizers do, which run while anything goes on."""
        products = current().render_products
        if products.get(self.path) is self:
            del products[self.path]

    def _is_read(self) -> bool:
        """Return whether a writer or annotator is attached to its path."""
        state = current()
        read = [each.render_product for each in state.annotators]
        return self.path in read or any(self.path in each.render_products for each in state.writers)

    def _repr_html_(self) -> str:
        from usdsdg.notebook.render_products import product_html

        return product_html(self)

    def _repr_png_(self) -> bytes | None:
        from usdsdg.notebook.render_products import product_png

        return product_png(self)

    def __repr__(self) -> str:
        return f"HydraTexture({self.path!r}, camera={self.camera_path!r}, resolution={self.resolution})"


def products() -> list[HydraTexture]:
    """All render products of the current stage, oldest first."""
    return list(current().render_products.values())


def product_at(path: str) -> HydraTexture:
    """Return the product with prim path `path`.

    Raises:
        BadPrim: there is no such product, or it has been destroyed; the message names similar paths, or all products.
    """
    known = current().render_products
    if path not in known:
        near = difflib.get_close_matches(path, known, n=2, cutoff=0.8)
        hint = f"did you mean {' or '.join(near)}?" if near else f"there are: {', '.join(known) or 'none'}."
        raise errors.BadPrim(f"there is no render product {path}, or it has been destroyed; {hint}")
    return known[path]


def add(product: HydraTexture) -> HydraTexture:
    """Register a product and return it."""
    current().render_products[product.path] = product
    return product


def reset() -> None:
    """Remove all products."""
    current().render_products.clear()
