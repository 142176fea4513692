"""The argument of a writer's `write`: the annotations of all its render products, in one of three layouts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from usdsdg.annotators.annotator import Annotator
from usdsdg.annotators.base import Annotation
from usdsdg.annotators.delivery import delivered
from usdsdg.annotators.frame import Frame
from usdsdg.errors import WriterError

LAYOUTS = ("legacy", "annotator", "renderProduct")
_NOT_ANNOTATORS = ("distribution_outputs", "trigger_outputs", "named_outputs")


@dataclass(frozen=True)
class Capture:
    """The part of a payload that comes from one render product."""

    camera: str  # prim path
    resolution: tuple[int, int]  # width, height
    annotations: Mapping[str, Annotation]  # by annotator name


class Reader(Protocol):
    """The receiver of a payload: a writer."""

    data_structure: str
    shares_arrays: bool  # whether it never modifies arrays and tables, so that they need not be copied for it

    @property
    def reads_numpy(self) -> bool: ...  # whether arrays that Warp kernels have augmented come as NumPy arrays

    @property
    def render_products(self) -> Sequence[str]: ...  # all that it is attached to, including those not in this payload

    def annotators_of(self, render_product: str) -> Sequence[Annotator]: ...


def build_payload(
    reader: Reader, frames: Mapping[str, Frame], *, frame_number: int | None = None, **outputs: Any
) -> dict[str, Any]:
    """Compute the annotators of `reader` and build its payload from `frames`, by render product path.

    frame_number: default, the index of the frames.
    outputs: trigger_outputs, distribution_outputs, named_outputs.
    """
    captures = {
        path.rsplit("/", 1)[-1]: Capture(
            frame.view.prim_path,
            (frame.view.width, frame.view.height),
            _annotations(reader.annotators_of(path), frame, reader),
        )
        for path, frame in frames.items()
    }
    first = next(iter(frames.values()), None)
    number = frame_number if frame_number is not None else first.index if first else 0
    time = first.reference_time if first else (0, 1)
    # Keys must not change when a product is disabled for a frame.
    several = max(len(reader.render_products), len(captures)) > 1
    return lay_out(
        reader.data_structure, captures, several=several, frame_number=number, reference_time=time, **outputs
    )


def _annotations(annotators: Sequence[Annotator], frame: Frame, reader: Reader) -> dict[str, Annotation]:
    """Compute annotators and return what they deliver, by name.

    These are copies, which the reader may write into, unless it shares them or an annotator does not copy arrays. What
    is delivered on the host comes from a GPU in one go.
    """
    computed = [(annotator, annotator.compute(frame)) for annotator in annotators]
    devices = [annotator.delivery.warp_device(kernels=not reader.reads_numpy) for annotator in annotators]
    frame.fetch(array for (_, each), device in zip(computed, devices) if device is None for array in each.images)
    return {
        annotator.get_name(): delivered(
            each,
            device,
            copy=annotator.delivery.copies and not reader.shares_arrays,
            copy_tables=not reader.shares_arrays,
            fetch=frame.on_host,
        )
        for (annotator, each), device in zip(computed, devices)
    }


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
    """Arrange `captures`, by render product name, in the layout of a writer.

    layout: a writer's `data_structure`. "legacy" names arrays after annotators, with "-<render product>" appended where
        the writer has `several`; "annotator" and "renderProduct" nest with that level outermost.

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
    """Raise a WriterError if there is no such layout."""
    if layout not in LAYOUTS:
        raise WriterError(f"{writer}: data_structure {layout!r} does not exist; it may be {', '.join(LAYOUTS)}.")


def by_annotator(data: Mapping[str, Any]) -> Mapping[str, Mapping[str, Any]]:
    """Return what a payload has under "annotators"; of one in the legacy layout, which scripts build, the same."""
    if "annotators" in data:
        return data["annotators"]
    laid_out: dict[str, dict[str, Any]] = {}
    for key, seen in data.items():
        name, _, product = key.partition("-")
        if isinstance(seen, np.ndarray):
            laid_out.setdefault(name, {})[product] = {"data": seen}
        elif isinstance(seen, Mapping) and key not in _NOT_ANNOTATORS and not key.startswith("rp_"):
            flat = {**seen.get("info", {}), **{each: value for each, value in seen.items() if each != "info"}}
            laid_out.setdefault(name, {})[product] = flat
    return laid_out


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
        for key, value in _product(capture).items():
            laid_out.setdefault(key, {})[product] = value
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
