"""What an annotator is: a named function from a `Frame` to an `Annotation`.

`define` registers the function together with what it needs rendered. Users hold an `Annotator` (annotator.py), which
binds the function to parameters, augmentations and a render product.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from usdsdg.annotators.default_filter import DefaultFilter
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.pixels.launch import Pixels, is_image
from usdsdg.arguments.registry import Registry
from usdsdg.errors import AnnotatorError, AnnotatorRegistryError
from usdsdg.session.session import current

# One encoder for all: `json.dumps` with options makes a new one in each call.
_text_of = json.JSONEncoder(sort_keys=True, default=str).encode


@dataclass(frozen=True)
class Annotation:
    """The output of an annotator for one frame: an array, metadata ("info"), or both.

    Images are where their kernels ran: NumPy arrays, or Warp arrays on a GPU. What users receive is in NumPy arrays,
    and in Warp arrays of annotators with a device.
    """

    data: Pixels | None = None
    info: Mapping[str, Any] = field(default_factory=dict)

    @property
    def images(self) -> Iterator[Pixels]:
        """Arrays that may be on a GPU: the data, and those of info."""
        yield from (each for each in (self.data, *self.info.values()) if is_image(each))

    def legacy(self) -> Any:
        """Return the array alone, or {"data", "info"}, or the info alone when there is no array."""
        if self.data is None:
            return dict(self.info)
        return {"data": self.data, "info": dict(self.info)} if self.info else self.data

    def flat(self) -> dict[str, Any]:
        """Return {"data": array, **info}."""
        return dict(self.info) if self.data is None else {"data": self.data, **self.info}


Compute = Callable[[Frame, Mapping[str, Any]], Annotation]


@dataclass(frozen=True)
class AnnotatorSpec:
    """A registered annotator: its function, what that needs rendered, and its init parameters."""

    name: str
    compute: Compute
    aovs: frozenset[str]
    needs_amodal_masks: bool  # reads `Frame.amodal_masks`
    needs_path_tracing: bool  # reads path-traced color ("LdrColor", "HdrColor") or light AOVs
    needs_poses: bool  # reads poses of labeled prims, or their bounds
    params: Mapping[str, Any]  # init parameters and their defaults
    empty: np.ndarray | None  # the array before the first frame; None for annotators without one
    empty_info: Mapping[str, Any] = field(default_factory=dict)  # info before the first frame
    on_attach: Callable[[Any], None] | None = None  # called with each `Annotator` that is attached
    check: Callable[[Mapping[str, Any]], None] | None = None  # called with init parameters when they are given

    def annotate(self, frame: Frame, params: Mapping[str, Any]) -> Annotation:
        """Compute the annotation of a frame.

        Raises:
            AnnotatorError: the function that a script has defined returns something else.
        """
        made = self.compute(frame, params)
        if not isinstance(made, Annotation):
            raise AnnotatorError(
                f"Annotator {self.name!r}: its function returned {type(made).__name__}; expected "
                "usdsdg.annotators.Annotation(data), or Annotation(data, info)."
            )
        return made

    def before_first_frame(self) -> Annotation:
        """Return an annotation of nothing, with the same keys as others; it may be written into."""
        return Annotation(self.empty, {key: copy.deepcopy(value) for key, value in self.empty_info.items()})

    def key_of(self, params: Mapping[str, Any]) -> tuple[Any, ...]:
        """Return what annotators with the same annotation have in common: the function and the text of `params`."""
        return "annotation", self.compute, _text_of(params)

    @property
    def documentation(self) -> str:
        return (self.compute.__doc__ or "").strip()


# What other tools call these by.
_LIKELY = {
    "depth": ("distance_to_image_plane", "distance_to_camera"),
    "mask": ("semantic_segmentation", "instance_segmentation"),
    "bbox": ("bounding_box_2d_tight", "bounding_box_2d_loose", "bounding_box_3d"),
    "color": ("rgb",),
}
annotator_specs: Registry[AnnotatorSpec] = Registry("annotator", AnnotatorRegistryError, likely=_LIKELY)

# Init parameters of every annotator that reads labels.
LABEL_PARAMS: Mapping[str, Any] = {"semanticTypes": None, "semanticFilter": None}


def define(
    *names: str,
    aovs: Iterable[str] = (),
    needs_amodal_masks: bool = False,
    needs_path_tracing: bool = False,
    needs_poses: bool = False,
    params: Mapping[str, Any] | None = None,
    dtype: Any = None,
    info: Mapping[str, Any] | None = None,
    on_attach: Callable[[Any], None] | None = None,
    check: Callable[[Mapping[str, Any]], None] | None = None,
) -> Callable[[Compute], Compute]:
    """Register the decorated function (frame, params) → `Annotation` under `names`.

    dtype: type of the returned array; None when the function returns info only.
    info: what there is of the returned info before the first frame, under the same keys: empty arrays, lists, tables.
    on_attach: called with each `Annotator` when it is attached.
    check: called with its init parameters when they are given, beside the label filter's; raises what is wrong.
    """

    empty = None if dtype is None else np.zeros(0, dtype)

    def register(compute: Compute) -> Compute:
        for name in names:
            spec = AnnotatorSpec(
                name,
                compute,
                frozenset(aovs),
                needs_amodal_masks,
                needs_path_tracing,
                needs_poses,
                params or {},
                empty,
                info or {},
                on_attach,
                check,
            )
            annotator_specs.add(name, spec, override=False)
        return compute

    return register


def predicate_of(params: Mapping[str, Any]) -> str | None:
    """Return the label filter of `semanticTypes` or `semanticFilter`, else the session's; None lets every label pass.

    The session's also takes the place of a `DefaultFilter` that is older.

    Raises:
        AnnotatorError: both are given, or one has the wrong type.
    """
    types, predicate = params.get("semanticTypes"), params.get("semanticFilter")
    if types is None and predicate is None:
        return current().label_filter
    names = [types] if types is None or isinstance(types, str) else types
    if not isinstance(names, (list, tuple, set)) or not all(name is None or isinstance(name, str) for name in names):
        raise AnnotatorError(f"semanticTypes is {types!r}; expected a list of types such as ['class'].")
    if not isinstance(predicate, (str, type(None))):
        raise AnnotatorError(f"semanticFilter is {predicate!r}; expected a predicate such as 'class:*'.")
    if types and predicate:
        raise AnnotatorError("semanticTypes and semanticFilter exclude each other; give one.")
    if types:
        return ";".join(f"{kind}:*" for kind in names)
    if isinstance(predicate, DefaultFilter):
        return predicate.in_force()
    return predicate or current().label_filter
