"""Segmentation colors shaded by a directional light, so that shapes stay visible."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import LABEL_PARAMS, Annotation, define
from usdsdg.annotators.colors import BACKGROUND, pastels_of_ids
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.kinds import segmentation

Params = Mapping[str, Any]

_SHADED: Params = {"useCandyColours": True, "lightSource": (1.0, 1.0, 1.0), "mapping": None}
# Brightness of surfaces that face away from the light.
_DARKEST = 0.5


@define(
    "shaded_semantic_segmentation", aovs=["instance", "normals"], params={**LABEL_PARAMS, **_SHADED}, dtype=np.uint8
)
def shaded_semantic_segmentation(frame: Frame, params: Params) -> Annotation:
    """semantic_segmentation, shaded: uint8 (H, W, 3), black where nothing is hit.

    useCandyColours: pastel colors; False gives those of colorize, with `mapping`.
    lightSource: direction toward the light, in the world.
    """
    return _shaded(segmentation.semantic_segmentation, frame, params)


@define(
    "shaded_instance_segmentation", aovs=["instance", "normals"], params={**LABEL_PARAMS, **_SHADED}, dtype=np.uint8
)
def shaded_instance_segmentation(frame: Frame, params: Params) -> Annotation:
    """instance_segmentation, shaded: uint8 (H, W, 3); parameters as shaded_semantic_segmentation."""
    return _shaded(segmentation.instance_segmentation, frame, params)


@define(
    "shaded_instance_id_segmentation", aovs=["instance", "normals"], params={**LABEL_PARAMS, **_SHADED}, dtype=np.uint8
)
def shaded_instance_id_segmentation(frame: Frame, params: Params) -> Annotation:
    """instance_id_segmentation, shaded: uint8 (H, W, 3); parameters as shaded_semantic_segmentation."""
    return _shaded(segmentation.instance_id_segmentation, frame, params)


def _shaded(segment: Callable[[Frame, Params], Annotation], frame: Frame, params: Params) -> Annotation:
    if params["useCandyColours"]:
        ids = segment(frame, {**params, "colorize": False}).data
        assert ids is not None
        present, indices = np.unique(ids, return_inverse=True)
        colors = pastels_of_ids(present)
        colors[present == BACKGROUND] = 0
        colors = colors[indices.reshape(ids.shape)]
    else:
        image = segment(frame, {**params, "colorize": True}).data
        assert image is not None
        colors = image[..., :3].astype(np.float32)
    light = np.asarray(params["lightSource"], np.float32)
    cosine = frame.aov("normals") @ (light / max(float(np.linalg.norm(light)), 1e-12))
    shade = np.clip(_DARKEST + (1 - _DARKEST) * (cosine + 1) / 2, 0, 1)
    return Annotation((colors * shade[..., None]).astype(np.uint8))
