"""`rep.preview`: a picture of the scene as it is now, with labels drawn in."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.arguments.registry import near_misses
from usdsdg.arguments.values import whole_number
from usdsdg.capture.still import still
from usdsdg.create.render_products import camera_below
from usdsdg.errors import AnnotatorError, ArgumentError, RenderError, Unsupported, warn_once
from usdsdg.graph.node import prim_paths
from usdsdg.pictures.overlays import OVERLAYS
from usdsdg.pictures.picture import Picture
from usdsdg.session.render_products import HydraTexture, size_problem

SIZE = (640, 480)
LABELS = ("instance_segmentation", "bounding_box_2d_tight")


def preview(
    camera: Any = None,
    resolution: Sequence[int] | None = None,
    *,
    labels: Sequence[str] | str = LABELS,
    samples: int | None = None,
) -> Picture:
    """Draw the scene as it is now, with labels in the picture. Nothing is counted, drawn at random, or written.

    A run gives the same frames and files with and without previews. Randomizers do not fire; call
    `orchestrator.preview()` or `step()` for that. A stage without lights is drawn with a plain sky and a sun.

    Args:
        camera: path, prim or item of a camera, or a render product. None: a camera that frames the whole scene.
        resolution: (width, height) [pixels]; by default that of the render product, else 640 x 480.
        labels: names of annotators to draw, in this order: semantic_segmentation, instance_segmentation,
            instance_id_segmentation, bounding_box_2d_tight, bounding_box_2d_loose, bounding_box_2d_amodal,
            bounding_box_3d, bounding_box_3d_360, keypoints. () draws the picture alone.
        samples: path-traced samples per pixel; None: the few of the fast mode.

    Returns:
        A `Picture`: a notebook shows it, `save(path)` writes it, `numpy.asarray` gives uint8 (H, W, 3).

    Raises:
        AnnotatorError: `labels` has a name that cannot be drawn.
        BadPrim: the camera is not on the stage.
        RenderError: the camera gives no image of this size.
        StageError: there is neither a camera nor anything visible.
    """
    wanted = _checked_labels(labels)
    path, size = _camera_and_size(camera, resolution)
    if samples is not None:
        whole_number("preview: samples", samples, least=1)
    drawn = still(
        path, size, [named_annotators.get(name) for name in ("rgb", "camera_params", *wanted)], samples=samples
    )
    if not drawn.has_light:
        warn_once("the stage has no light: previews have a plain sky and a sun, which captured frames do not have")
    seen = drawn.annotations
    picture = np.asarray(seen["rgb"].data)[..., :3]
    for name in wanted:
        picture = OVERLAYS[name](picture, seen[name], seen["camera_params"].info)
    return Picture(picture)


def _checked_labels(labels: Sequence[str] | str) -> list[str]:
    wanted = [labels] if isinstance(labels, str) else list(labels)
    for name in wanted:
        if name not in OVERLAYS:
            close = near_misses(name, OVERLAYS)
            hint = f"Did you mean {close[0]!r}?" if close else f"It may be {', '.join(OVERLAYS)}."
            raise AnnotatorError(f"preview: labels has {name!r}, which cannot be drawn. {hint}")
    return wanted


def _camera_and_size(camera: Any, resolution: Sequence[int] | None) -> tuple[str | None, tuple[int, int]]:
    """Return the path of the camera, None for the whole scene, and width and height."""
    if isinstance(camera, HydraTexture):
        if camera.tiles is not None:
            raise Unsupported(f"preview: {camera.path} shows cameras in tiles; give one of its cameras")
        camera, resolution = camera.camera_path, camera.resolution if resolution is None else resolution
    width, height = _size(SIZE if resolution is None else resolution)
    if camera is None:
        return None, (width, height)
    paths = prim_paths(camera)
    if len(paths) != 1:
        raise ArgumentError(f"preview: camera is {len(paths)} prims; give one camera")
    return camera_below(paths[0]), (width, height)


def _size(resolution: Sequence[int]) -> tuple[int, int]:
    try:
        width, height = (whole_number("resolution", each) for each in resolution)
    except (TypeError, ValueError):
        raise ArgumentError(f"preview: resolution is {resolution!r}; expected (width, height) in pixels") from None
    if problem := size_problem(width, height):
        raise RenderError(f"preview: {problem}")
    return width, height
