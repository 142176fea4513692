"""What a writer's `write` receives: the annotations of all its render products, in one of three layouts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from usdsdg.annotators.annotator import Annotator
from usdsdg.annotators.base import Annotation
from usdsdg.annotators.frame import Frame
from usdsdg.errors import WriterError

LAYOUTS = ("legacy", "annotator", "renderProduct")


@dataclass(frozen=True)
class Capture:
    """What one render product gives to a payload."""

    camera: str  # prim path
    resolution: tuple[int, int]  # width, height
    annotations: Mapping[str, Annotation]  # by annotator name


class Reader(Protocol):
    """Who a payload is for: a writer."""

    data_structure: str
    render_products: Sequence[str]  # those that it is attached to, whether they are in this payload or not
    shares_arrays: bool  # whether it leaves arrays as they are, so that it needs none of its own

    def annotators_of(self, render_product: str) -> Sequence[Annotator]: ...


def build_payload(
    reader: Reader, frames: Mapping[str, Frame], *, frame_number: int | None = None, **outputs: Any
) -> dict[str, Any]:
    """The payload for `reader` of `frames`, by render product path; computes its annotators.

    frame_number: default, the index of the frames.
    outputs: trigger_outputs, distribution_outputs, named_outputs.
    """
    captures = {
        path.rsplit("/", 1)[-1]: Capture(
            frame.camera.prim_path,
            (frame.camera.width, frame.camera.height),
            {
                annotator.get_name(): _own(annotator.compute(frame), shared=reader.shares_arrays)
                for annotator in reader.annotators_of(path)
            },
        )
        for path, frame in frames.items()
    }
    first = next(iter(frames.values()), None)
    number = frame_number if frame_number is not None else first.index if first else 0
    time = first.reference_time if first else (0, 1)
    # One that is switched off for a frame does not rename what the others give.
    several = max(len(reader.render_products), len(captures)) > 1
    return lay_out(
        reader.data_structure, captures, several=several, frame_number=number, reference_time=time, **outputs
    )


def _own(annotation: Annotation, *, shared: bool) -> Annotation:
    """The annotation with arrays that its reader may write into, unless they are to be shared."""
    if shared:
        return annotation
    info = {key: value.copy() if isinstance(value, np.ndarray) else value for key, value in annotation.info.items()}
    return Annotation(None if annotation.data is None else annotation.data.copy(), info)


def lay_out(
    layout: str,
    captures: Mapping[str, Capture],
    *,
    several: bool,
    frame_number: int,
    reference_time: tuple[int, int] = (0, 1),
    distribution_outputs: Mapping[str, Any] | None = None,
    trigger_outputs: Mapping[str, Any] | None = None,
    named_outputs: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """The payload of `captures`, by render product name.

    layout: a writer's `data_structure`. "legacy" names arrays after annotators, with "-<render product>" appended where
        the writer has `several`; "annotator" and "renderProduct" nest, in the order that the word says.

    Raises:
        WriterError: there is no such layout.
    """
    check_layout(layout)
    payload: dict[str, Any] = {
        "swhFrameNumber": frame_number,
        "reference_time": tuple(reference_time),
        "distribution_outputs": dict(distribution_outputs or {}),
        "trigger_outputs": dict(trigger_outputs or {}),
        "named_outputs": dict(named_outputs or {}),
    }
    payload.update(_LAYOUTS[layout](captures, several))
    return payload


def check_layout(layout: str, writer: str = "A writer") -> None:
    """Raises WriterError where there is no such layout."""
    if layout not in LAYOUTS:
        raise WriterError(f"{writer}: data_structure {layout!r} does not exist; it may be {', '.join(LAYOUTS)}.")


def _legacy(captures: Mapping[str, Capture], several: bool) -> dict[str, Any]:
    laid_out: dict[str, Any] = {}
    for product, capture in captures.items():
        suffix = f"-{product}" if several else ""
        for name, annotation in capture.annotations.items():
            laid_out[name + suffix] = annotation.legacy()
        laid_out[f"rp_{product}"] = _product(capture)
    return laid_out


def _by_annotator(captures: Mapping[str, Capture], several: bool) -> dict[str, Any]:
    laid_out: dict[str, dict[str, Any]] = {}
    for product, capture in captures.items():
        for name, annotation in capture.annotations.items():
            laid_out.setdefault(name, {})[product] = annotation.flat()
        for fact, value in _product(capture).items():
            laid_out.setdefault(fact, {})[product] = value
    return {"annotators": laid_out}


def _by_render_product(captures: Mapping[str, Capture], several: bool) -> dict[str, Any]:
    return {
        "renderProducts": {
            product: {**{name: a.flat() for name, a in capture.annotations.items()}, **_product(capture)}
            for product, capture in captures.items()
        }
    }


_LAYOUTS = {"legacy": _legacy, "annotator": _by_annotator, "renderProduct": _by_render_product}


def _product(capture: Capture) -> dict[str, Any]:
    return {"camera": capture.camera, "resolution": np.array(capture.resolution)}
