"""`isaacsim.core.utils.render_product`: cameras and sizes of render products, by the paths of their prims."""

from __future__ import annotations

from collections.abc import Sequence

from usdsdg.create.render_products import render_product
from usdsdg.errors import Unsupported
from usdsdg.session.render_products import HydraTexture, product_at


def create_hydra_texture(resolution: Sequence[int], camera_prim_path: str) -> tuple[HydraTexture, str]:
    """Create a render product of a camera; return it and the path of its prim.

    Raises:
        BadPrim: there is no such camera.
        RenderError: an image of this size is not possible.
    """
    product = render_product(camera_prim_path, tuple(resolution), force_new=True)
    assert isinstance(product, HydraTexture)
    return product, product.path


def get_camera_prim_path(render_product_path: str) -> str:
    """Return the path of the camera that a render product shows.

    Raises:
        BadPrim: there is no such render product.
    """
    return product_at(str(render_product_path)).camera_path


def set_camera_prim_path(render_product_path: str, camera_prim_path: str) -> None:
    """Let a render product show another camera from now on.

    Raises:
        BadPrim: there is no such render product, or no such camera.
    """
    product_at(str(render_product_path)).set_camera(str(camera_prim_path))


def get_resolution(render_product_path: str) -> tuple[int, int]:
    """Return width and height of the images of a render product [pixels].

    Raises:
        BadPrim: there is no such render product.
    """
    return product_at(str(render_product_path)).resolution


def set_resolution(render_product_path: str, resolution: Sequence[int]) -> None:
    """Set width and height of the images of a render product [pixels] from now on.

    Raises:
        BadPrim: there is no such render product.
        RenderError: an image of this size is not possible.
    """
    product_at(str(render_product_path)).set_resolution(resolution)


def add_aov(render_product_path: str, aov_name: str) -> None:
    """Refuse: AOVs are read by annotators.

    Raises:
        Unsupported: always.
    """
    raise Unsupported(
        f"add_aov: render products have no AOVs of their own; rep.annotators.get({aov_name!r}), attached to "
        f"{render_product_path}, gives what it would hold, if there is an annotator of this name"
    )
