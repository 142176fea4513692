"""What an annotator holds: a picture, colored masks, boxes drawn over the picture, or a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from usdsdg.annotators.annotator import Annotator, attached_annotators
from usdsdg.annotators.base import Annotation
from usdsdg.errors import BadPrim
from usdsdg.notebook import html
from usdsdg.pictures import overlays
from usdsdg.pictures.arrays import looks_like_image, picture_of
from usdsdg.pictures.picture import Picture
from usdsdg.session.render_products import product_at
from usdsdg.writers.formats.class_names import shown_labels

_GRAY = 96
_RGB = ("rgb", "LdrColor")


def annotator_html(annotator: Annotator) -> str:
    """Return what a notebook shows of an annotator; it is not computed again."""
    if annotator.render_product is None:
        about = "not attached; attach(render_product) gives it a picture to label"
        return html.title(annotator.name, about) + html.note(_first_sentence(annotator.documentation))
    where = f"of {annotator.render_product}"
    held = annotator.held()
    if held is None:
        return html.title(annotator.name, f"{where}; nothing yet: orchestrator.step() captures a frame")
    parts = [html.title(annotator.name, f"{where}{_shape(held)}")]
    if (drawn := drawn_picture(annotator, held)) is not None:
        parts += [html.image(drawn[0]), html.note(drawn[1])]
    return "".join([*parts, _tables(held)])


def annotator_png(annotator: Annotator) -> bytes | None:
    """Return the picture of what an annotator holds as a PNG; None if it holds none."""
    held = annotator.held() if annotator.render_product is not None else None
    drawn = drawn_picture(annotator, held) if held is not None else None
    return None if drawn is None else Picture(drawn[0])._repr_png_()


def drawn_picture(annotator: Annotator, held: Annotation) -> tuple[np.ndarray, str] | None:
    """Return the picture of an annotation, uint8 (H, W, 3), and what its colors mean; None if it has none."""
    name, array = annotator.template_name.removesuffix("_fast"), held.data
    if array is None or not np.size(array):
        return None
    array = np.asarray(array)
    camera = _held_by(annotator, ("camera_params", "CameraParams"))
    if array.dtype.names:
        draw = overlays.OVERLAYS.get(name)
        if draw is None or (draw is overlays.cuboids and camera is None):
            return None
        return draw(_ground(annotator), held, camera.info if camera is not None else {}), ""
    return picture_of(name, array) if looks_like_image(array) else None


def _ground(annotator: Annotator) -> np.ndarray:
    """Return the picture that boxes are drawn over: that of the same product if it is held too, else gray."""
    rgb = _held_by(annotator, _RGB)
    if rgb is not None and rgb.data is not None and np.size(rgb.data):
        return np.asarray(rgb.data)[..., :3]
    try:
        width, height = product_at(str(annotator.render_product)).resolution
    except BadPrim:
        width, height = 640, 480
    return np.full((height, width, 3), _GRAY, np.uint8)


def _held_by(annotator: Annotator, names: Sequence[str]) -> Annotation | None:
    """Return what another annotator of the same render product holds, of the first with one of these names."""
    for other in attached_annotators():
        if other.template_name in names and other.render_product == annotator.render_product and other.has_data:
            return other.held()
    return None


def _tables(held: Annotation) -> str:
    parts = []
    array = None if held.data is None else np.asarray(held.data)
    if array is not None and array.dtype.names:
        parts.append(_rows(held, array))
    elif array is not None and not looks_like_image(array) and array.size:
        parts.append(
            html.table(("values",), [(np.array2string(each, precision=4),) for each in array[: html.ROWS + 1]])
        )
    labels = held.info.get("idToLabels") if array is None or not array.dtype.names else None
    if isinstance(labels, Mapping):
        parts.append(html.table(("id", "labels"), [(key, shown_labels(value)) for key, value in labels.items()]))
    if array is None:
        parts.append(html.table(("name", "value"), [(key, _short(value)) for key, value in held.info.items()]))
    return "".join(parts)


def _rows(held: Annotation, array: np.ndarray) -> str:
    """Return a table of structured rows, with labels and prims where the annotation has them."""
    heads = list(array.dtype.names or ())
    rows = [[_short(row[name]) for name in heads] for row in array]
    if "semanticId" in heads and "idToLabels" in held.info:
        heads, rows = ["labels", *heads], [[name, *row] for name, row in zip(overlays.names(held), rows)]
    paths = held.info.get("primPaths")
    if paths is not None and len(paths) == len(rows):
        heads, rows = [*heads, "prim"], [[*row, path] for row, path in zip(rows, paths)]
    return html.table(heads, rows) if rows else html.note("no rows: nothing of it is in the picture")


def _short(value: Any) -> str:
    return np.array2string(np.asarray(value), precision=4, threshold=16) if np.ndim(value) else f"{_rounded(value)}"


def _rounded(value: Any) -> Any:
    return f"{float(value):.4g}" if isinstance(value, (float, np.floating)) else value


def _shape(held: Annotation) -> str:
    return "" if held.data is None else f": {'x'.join(map(str, np.shape(held.data)))} {_dtype(np.asarray(held.data))}"


def _dtype(array: np.ndarray) -> str:
    return "rows" if array.dtype.names else str(array.dtype)


def _first_sentence(documentation: str) -> str:
    return " ".join(documentation.split()).partition(". ")[0]
