"""DataVisualizationWriter: boxes drawn over pictures, to look at labels."""

import os
from collections.abc import Callable, Mapping
from numbers import Integral
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from usdsdg.annotators import named_annotators
from usdsdg.errors import WriterError, warn_once
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.group import make_backend
from usdsdg.writers.base import Writer
from usdsdg.writers.files import checked_padding, write_image
from usdsdg.writers.formats.shapes import cuboid
from usdsdg.writers.formats.shapes.camera_projection import edge_pixels
from usdsdg.writers.formats.writer_basic import colorize_normals
from usdsdg.writers.options import typed

TIGHT, LOOSE = "bounding_box_2d_tight_fast", "bounding_box_2d_loose_fast"
SOLID, CAMERA = "bounding_box_3d_fast", "camera_params"
BACKGROUNDS: dict[str, Callable[[np.ndarray], np.ndarray]] = {"rgb": np.asarray, "normals": colorize_normals}
# What `*_params` may have, by whether boxes are rectangles or solids.
_RECTANGLE, _SOLID = ("background", "fill", "outline", "width"), ("background", "fill", "width")
_LINE_COLOR = "green"

Style = Mapping[str, Any]


class DataVisualizationWriter(Writer):
    """Writes `<render product>/<annotator>_NNNN.png` for each kind of boxes: a picture with the boxes in it.

    Edges of 3D boxes are clipped to what is in front of the camera, and curved where the lens curves them.
    """

    BB_2D_TIGHT, BB_2D_LOOSE, BB_3D = TIGHT, LOOSE, SOLID
    SUPPORTED_BACKGROUNDS = list(BACKGROUNDS)

    version = "0.1.0"
    data_structure = "renderProduct"
    shares_arrays = True

    @typed
    def __init__(
        self,
        output_dir: str | os.PathLike | None = None,
        bounding_box_2d_tight: bool = False,
        bounding_box_2d_tight_params: Mapping | None = None,
        bounding_box_2d_loose: bool = False,
        bounding_box_2d_loose_params: Mapping | None = None,
        bounding_box_3d: bool = False,
        bounding_box_3d_params: Mapping | None = None,
        frame_padding: int = 4,
        *,
        backend: BaseBackend | None = None,
    ) -> None:
        """
        bounding_box_2d_tight_params, bounding_box_2d_loose_params: `background` ("rgb" or "normals"; by default the
            picture is transparent), `outline` and `fill` colors as Pillow reads them (green, and none), `width` in
            pixels (1).
        bounding_box_3d_params: `background`, `fill` as the color of the edges, and `width`.

        Other parameters and backgrounds are ignored with a warning, as Isaac Sim ignores them.

        Raises:
            WriterError: an option has an invalid value, or there is nowhere to write.
            OutputNotWritable: output_dir cannot be written to.
        """
        self.backend = make_backend("DataVisualizationWriter", output_dir, backend)
        self._padding = checked_padding(frame_padding)
        self._frame_id = 0
        wanted = (
            (TIGHT, bounding_box_2d_tight, bounding_box_2d_tight_params),
            (LOOSE, bounding_box_2d_loose, bounding_box_2d_loose_params),
            (SOLID, bounding_box_3d, bounding_box_3d_params),
        )
        self._styles = {name: _checked_style(name, style or {}) for name, enabled, style in wanted if enabled}
        backgrounds = {style["background"] for style in self._styles.values() if style.get("background")}
        needed = [*self._styles, *sorted(backgrounds), *([CAMERA] if SOLID in self._styles else [])]
        self.annotators = [named_annotators.get(name) for name in needed]

    def write(self, data: dict[str, Any]) -> None:
        assert self.backend is not None
        for product, seen in data["renderProducts"].items():
            for name, style in self._styles.items():
                picture = _background(seen, style)
                draw = ImageDraw.Draw(picture)
                if name == SOLID:
                    _draw_solids(draw, seen[name]["data"], seen[CAMERA], style)
                else:
                    _draw_rectangles(draw, seen[name]["data"], style)
                path = f"{product}/{name}_{self._frame_id:0{self._padding}}.png"
                self.backend.schedule(write_image, path=path, data=np.asarray(picture))
        self._frame_id += 1


def _checked_style(annotator: str, style: Style) -> Style:
    """Return the parameters of a kind of boxes that have an effect; warn of others.

    Raises:
        WriterError: a color is none.
    """
    known = _SOLID if annotator == SOLID else _RECTANGLE
    where = f"DataVisualizationWriter: {annotator.removesuffix('_fast')}_params"
    if unknown := [name for name in style if name not in known]:
        warn_once(f"{where}: {', '.join(map(repr, unknown))} has no effect; known are {', '.join(known)}")
    background = style.get("background")
    if background not in (None, *BACKGROUNDS):
        warn_once(
            f"{where}: background {background!r} is none of {', '.join(BACKGROUNDS)}, so the picture is transparent"
        )
        style = {**style, "background": None}
    for name in ("fill", "outline"):
        if not _is_color(style.get(name)):
            raise WriterError(f"{where}: {name} {style[name]!r} is no color that Pillow knows.")
    width = style.get("width", 1)
    if not isinstance(width, Integral) or width < 0:
        raise WriterError(f"{where}: width is {width!r}; expected a whole number of pixels.")
    return style


def _is_color(value: Any) -> bool:
    """Return whether Pillow takes a value for a color of its own; None is none."""
    try:
        Image.new("RGBA", (1, 1), _color(value))
    except (ValueError, TypeError, OverflowError):
        return False
    return True


def _background(seen: Mapping[str, Any], style: Style) -> Image.Image:
    name = style.get("background")
    if name is None:
        width, height = (int(size) for size in seen["resolution"])
        return Image.new("RGBA", (width, height))
    return Image.fromarray(np.ascontiguousarray(BACKGROUNDS[name](seen[name]["data"])).copy())


def _draw_rectangles(draw: ImageDraw.ImageDraw, boxes: np.ndarray, style: Style) -> None:
    for box in boxes:
        corners = [int(box[name]) for name in ("x_min", "y_min", "x_max", "y_max")]  # inclusive, as Pillow draws
        color = _color(style.get("outline", _LINE_COLOR))
        draw.rectangle(corners, fill=_color(style.get("fill")), outline=color, width=style.get("width", 1))


def _draw_solids(draw: ImageDraw.ImageDraw, boxes: np.ndarray, camera: Mapping[str, Any], style: Style) -> None:
    view = np.asarray(camera["cameraViewTransform"], np.float64).reshape(4, 4)
    color, width = _color(style.get("fill", _LINE_COLOR)), style.get("width", 1)
    for box in boxes:
        low, high = ([box[f"{axis}_{end}"] for axis in "xyz"] for end in ("min", "max"))
        corners = cuboid.keypoints(np.array(low), np.array(high))
        to_camera = np.asarray(box["transform"], np.float64).reshape(4, 4) @ view
        edges = cuboid.edge_segments(corners) @ to_camera[:3, :3] + to_camera[3, :3]
        for (x0, y0), (x1, y1) in np.concatenate(edge_pixels(edges, camera)):
            draw.line([x0, y0, x1, y1], fill=color, width=width)


def _color(color: Any) -> Any:
    """Return a color for Pillow, which takes no lists, as YAML gives them."""
    return tuple(color) if isinstance(color, list) else color
