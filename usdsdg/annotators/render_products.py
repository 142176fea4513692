"""Render products as users give them to `attach` and `detach`: handles, prim paths, or lists of either."""

from collections.abc import Sequence
from typing import Any

from usdsdg.errors import AnnotatorError, ArgumentError, BadPrim
from usdsdg.session.render_products import HydraTexture, product_at


def render_product_paths(render_products: Any) -> list[str]:
    """Return the prim paths of a render product, of a path, or of a list of either.

    Raises:
        AnnotatorError: an item is neither.
    """
    paths = []
    for item in _listed(render_products):
        path = str(getattr(item, "path", item) or "")
        if not path.startswith("/"):
            raise AnnotatorError(
                f"{item!r} is not a render product: give what create.render_product returned, or its path."
            )
        paths.append(path)
    return paths


def chosen_products(paths: Sequence[str], indices: Sequence[int], annotator: str) -> list[str]:
    """Return those of some render products that have the given indices.

    Raises:
        ArgumentError: there is none with such an index.
    """
    if missing := [each for each in indices if not 0 <= each < len(paths)]:
        raise ArgumentError(
            f"Annotator {annotator!r} has render_product_idxs={list(indices)}: there is no render product "
            f"{missing[0]}, of {len(paths)} counted from 0"
        )
    return [paths[index] for index in indices]


def existing_products(render_products: Any) -> list[str]:
    """Return the prim paths as `render_product_paths` does, and check that the products exist.

    Raises:
        AnnotatorError: an item is not a render product.
        BadPrim: one does not exist, and the message names near misses; or a handle is of an earlier stage.
    """
    items = _listed(render_products)
    paths = render_product_paths(items)
    for item, path in zip(items, paths):
        product = product_at(path)
        if isinstance(item, HydraTexture) and item is not product:
            raise BadPrim(
                f"the render product given was {path} before a new stage or destroy() removed it, and another one has "
                "this path now. Give what create.render_product returned for that."
            )
    return paths


def _listed(render_products: Any) -> list[Any]:
    return list(render_products) if isinstance(render_products, (list, tuple, set)) else [render_products]
