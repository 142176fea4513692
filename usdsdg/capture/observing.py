"""Observation of captured frames: whether pictures have light in them, and labels in view."""

from collections.abc import Mapping

import numpy as np

from usdsdg.annotators.frame import Frame
from usdsdg.capture.requests import Requests
from usdsdg.session.session import current


def observe(requests: Requests, frames: Mapping[str, Frame]) -> None:
    """Add the frame of each product, by path, to the observations of the session.

    Images are looked at only until one has shown light, and one a label.
    """
    seen = current().observations
    seen.frames += 1
    for path, frame in frames.items():
        if "LdrColor" in frame.aovs:
            seen.add_picture(255 if seen.light_seen else float(frame.aov("LdrColor")[..., :3].max()))
        reading = [annotator for annotator in requests.annotators[path] if annotator.reads_labels]
        if reading:
            seen.add_labels(seen.label_seen or _has_label(frame))


def _has_label(frame: Frame) -> bool:
    """Whether any pixel shows a labeled prim."""
    labeled = np.append(frame.labeled_prims.row_of_gprim >= 0, False)  # index -1, no hit, is the last entry
    return bool(labeled.any()) and bool(labeled[frame.aov("instance")].any())
