"""Segmentation colors shaded by a directional light, so that shapes stay visible."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import LABEL_PARAMS, Annotation, define
from usdsdg.annotators.colors import BACKGROUND, pastels_of_ids
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.kinds import segmentation
from usdsdg.annotators.kinds.id_mapping import check_mapping
from usdsdg.annotators.kinds.segmentation import Shown
from usdsdg.annotators.pixels import look_ups

Params = Mapping[str, Any]

_SHADED: Params = {"useCandyColours": True, "lightSource": (1.0, 1.0, 1.0), "mapping": None}
_NEEDS: Mapping[str, Any] = {
    "aovs": ["instance", "normals"], "params": {**LABEL_PARAMS, **_SHADED}, "dtype": np.uint8, "check": check_mapping,
}  # fmt: skip
# Brightness of surfaces that face away from the light.
_DARKEST = 0.5


@define("shaded_semantic_segmentation", **_NEEDS)
def shaded_semantic_segmentation(frame: Frame, params: Params) -> Annotation:
    """semantic_segmentation, shaded: uint8 (H, W, 3), black where nothing is hit.

    useCandyColours: pastel colors; False gives those of colorize, with `mapping`.
    lightSource: direction toward the light, in the world.
    """
    return _shaded(segmentation.shown_classes, frame, params)


@define("shaded_instance_segmentation", **_NEEDS)
def shaded_instance_segmentation(frame: Frame, params: Params) -> Annotation:
    """instance_segmentation, shaded: uint8 (H, W, 3); parameters as shaded_semantic_segmentation."""
    return _shaded(segmentation.shown_prims, frame, params)


@define("shaded_instance_id_segmentation", **_NEEDS)
def shaded_instance_id_segmentation(frame: Frame, params: Params) -> Annotation:
    """instance_id_segmentation, shaded: uint8 (H, W, 3); parameters as shaded_semantic_segmentation."""
    return _shaded(segmentation.shown_gprims, frame, params)


def _shaded(segment: Callable[[Frame, Params], Shown], frame: Frame, params: Params) -> Annotation:
    table = segment(frame, params)
    if params["useCandyColours"]:
        colors = pastels_of_ids(table.ids)
        colors[table.ids == BACKGROUND] = 0
    else:
        colors = table.colors.values[:, :3]
    light = np.asarray(params["lightSource"], np.float32)
    light /= max(float(np.linalg.norm(light)), 1e-12)
    return Annotation(look_ups.shade(frame.image("instance"), frame.image("normals"), colors, light, _DARKEST))
