"""Render products as users give them to `attach` and `detach`: handles, prim paths, or lists of either."""

from __future__ import annotations

from typing import Any

from usdsdg.errors import AnnotatorError
from usdsdg.session.render_products import product_at


def render_product_paths(render_products: Any) -> list[str]:
    """Prim paths of a render product, of its path, or of a list of either.

    Raises:
        AnnotatorError: something in it is neither.
    """
    items = render_products if isinstance(render_products, (list, tuple, set)) else [render_products]
    paths = []
    for item in items:
        path = str(getattr(item, "path", item) or "")
        if not path.startswith("/"):
            raise AnnotatorError(
                f"{item!r} is not a render product: give what create.render_product returned, or its path."
            )
        paths.append(path)
    return paths


def existing_products(render_products: Any) -> list[str]:
    """As `render_product_paths`, of products that exist.

    Raises:
        AnnotatorError: something in it is no render product.
        BadPrim: one does not exist, or not any more; the message names near misses.
    """
    return [product_at(path).path for path in render_product_paths(render_products)]
