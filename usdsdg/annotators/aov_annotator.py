"""Annotators that users register for an AOV: its array under another name, dtype or number of channels."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from usdsdg.annotators.base import Annotation, AnnotatorSpec, annotator_specs
from usdsdg.annotators.frame import Frame
from usdsdg.arguments.registry import near_misses
from usdsdg.errors import AnnotatorRegistryError, Unsupported
from usdsdg.session import engines

# Omniverse's other names of AOVs.
_SYNONYMS = {
    "DistanceToCameraSD": "distance_to_camera",
    "DistanceToImagePlaneSD": "distance_to_image_plane",
    "NormalSD": "normals",
    "TargetMotionSD": "MotionVectors",
    "CrossCorrespondenceSD": "CrossCorrespondence",
    "DepthSensorLeftImager": "DepthSensorImager",
}


def register_aov(
    name: str,
    aov: str,
    dtype: Any,
    channels: int,
    on_attach: Callable[[Any], None] | None,
    documentation: str | None,
    unsupported: Mapping[str, str],
) -> None:
    """Register an annotator; see `AnnotatorRegistry.register_annotator_from_aov`."""
    source = _source(aov, unsupported)
    wanted = None if dtype is None else np.dtype(dtype)

    def compute(frame: Frame, params: Mapping[str, Any]) -> Annotation:
        data = source.compute(frame, source.params).data
        assert data is not None
        if wanted is None and channels == 1:
            return Annotation(data)
        data = frame.on_host(data)
        if data.ndim > 2 and channels > 1:
            data = data[..., :channels]
        return Annotation(data if wanted is None else data.astype(wanted, copy=False))

    compute.__doc__ = documentation or source.documentation
    assert source.empty is not None
    empty = source.empty if wanted is None else np.zeros(0, wanted)
    annotator_specs.add(
        name, replace(source, name=name, compute=compute, params={}, empty=empty, empty_info={}, on_attach=on_attach)
    )


def _source(aov: str, unsupported: Mapping[str, str]) -> AnnotatorSpec:
    """Return the annotator whose array is `aov`, or a new one for an AOV of the renderer."""
    known = _SYNONYMS.get(aov, aov)
    if known not in annotator_specs and known.removesuffix("SD") in annotator_specs:
        known = known.removesuffix("SD")  # as scripts of earlier versions name render variables
    if known in annotator_specs and annotator_specs.get(known).empty is not None:
        return annotator_specs.get(known)
    if aov in unsupported:
        raise Unsupported(f"AOV {aov!r}: {unsupported[aov]}.")
    aovs = engines.renderer_aovs()
    if known in aovs:
        return AnnotatorSpec(aov, _whole(known), frozenset([known]), False, False, False, {}, np.zeros(0, aovs[known]))
    names = [*aovs, *_SYNONYMS, *(each for each in annotator_specs if annotator_specs.get(each).empty is not None)]
    close = near_misses(aov, names)
    hint = f"Did you mean {' or '.join(map(repr, close))}?" if close else f"There are: {', '.join(names)}."
    raise AnnotatorRegistryError(f"No AOV is named {aov!r}. {hint}")


def _whole(aov: str) -> Callable[[Frame, Mapping[str, Any]], Annotation]:
    def whole(frame: Frame, params: Mapping[str, Any]) -> Annotation:
        """The renderer's AOV as it is."""
        return Annotation(frame.image(aov))

    return whole
