"""What a render product shows: its camera and size, and the pictures of the annotators that are attached to it."""

from __future__ import annotations

import numpy as np

from usdsdg.annotators.annotator import attached_annotators
from usdsdg.notebook import html
from usdsdg.notebook.annotators import drawn_picture
from usdsdg.pictures.picture import Picture
from usdsdg.session.render_products import HydraTexture
from usdsdg.writers.base import attached_writers

_WIDTH = 320


def product_html(product: HydraTexture) -> str:
    """Return what a notebook shows of a render product; nothing is rendered for it."""
    cameras = product.camera_path if product.tiles is None else f"{len(product.tiles.cameras)} cameras in tiles"
    state = "" if product.updates_enabled else ", updates are off"
    parts = [html.title(product.path, f"{product.width} x {product.height} of {cameras}{state}")]
    parts.append(
        html.row(
            html.image(pixels, width=min(_WIDTH, pixels.shape[1])) + html.note(name)
            for name, pixels in _pictures(product)
        )
    )
    names = [type(writer).__name__ for writer in attached_writers() if product.path in writer.render_products]
    parts.append(html.note(f"writers: {', '.join(names)}" if names else ""))
    if not _pictures(product):
        parts.append(html.note("no annotator holds a picture of it; rep.preview(product) draws one"))
    return "".join(parts)


def product_png(product: HydraTexture) -> bytes | None:
    """Return the first picture that an annotator holds of a render product as a PNG; None if none does."""
    found = _pictures(product)
    return Picture(found[0][1])._repr_png_() if found else None


def _pictures(product: HydraTexture) -> list[tuple[str, np.ndarray]]:
    found = []
    for annotator in attached_annotators():
        held = annotator.held() if annotator.render_product == product.path else None
        drawn = drawn_picture(annotator, held) if held is not None else None
        if drawn is not None:
            found.append((annotator.name, drawn[0]))
    return found
