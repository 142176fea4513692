"""The contract of the family: an annotator is a named function from a `Frame` to an `Annotation`.

A member is one function, registered with `define` together with what it needs rendered. Users hold an `Annotator`
(annotator.py), which binds the function to parameters, augmentations and a render product.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from usdsdg.annotators.frame import Frame
from usdsdg.arguments.registry import Registry
from usdsdg.errors import AnnotatorError, AnnotatorRegistryError


@dataclass(frozen=True)
class Annotation:
    """What an annotator says of one frame: an array, facts about it, or both."""

    data: np.ndarray | None = None
    info: Mapping[str, Any] = field(default_factory=dict)

    def legacy(self) -> Any:
        """The array alone, or {"data", "info"}, or the facts when there is no array."""
        if self.data is None:
            return dict(self.info)
        return {"data": self.data, "info": dict(self.info)} if self.info else self.data

    def flat(self) -> dict[str, Any]:
        """{"data": array, **facts}."""
        return dict(self.info) if self.data is None else {"data": self.data, **self.info}


@dataclass(frozen=True)
class Kind:
    """A member of the family, as registered."""

    name: str
    compute: Callable[[Frame, Mapping[str, Any]], Annotation]
    aovs: frozenset[str]
    needs_coverage: bool
    needs_picture: bool
    params: Mapping[str, Any]  # init parameters and their defaults
    empty: np.ndarray | None  # the array before the first frame; None for annotators without one
    on_attach: Callable[[Any], None] | None = None  # told of each `Annotator` that is attached

    @property
    def documentation(self) -> str:
        return (self.compute.__doc__ or "").strip()


kinds: Registry[Kind] = Registry("annotator", AnnotatorRegistryError)

# Init parameters of every annotator that reads labels.
LABEL_PARAMS: Mapping[str, Any] = {"semanticTypes": None, "semanticFilter": None}


def define(
    *names: str,
    aovs: Iterable[str] = (),
    needs_coverage: bool = False,
    needs_picture: bool = False,
    params: Mapping[str, Any] | None = None,
    dtype: Any = None,
) -> Callable:
    """Register the decorated function (frame, params) → `Annotation` under `names`.

    dtype: of the array it returns; None when it returns facts only.
    """

    def register(compute: Callable[[Frame, Mapping[str, Any]], Annotation]) -> Callable:
        for name in names:
            empty = None if dtype is None else np.zeros(0, dtype)
            kinds.add(
                name,
                Kind(name, compute, frozenset(aovs), needs_coverage, needs_picture, params or {}, empty),
                override=False,
            )
        return compute

    return register


def predicate_of(params: Mapping[str, Any]) -> str | None:
    """The label filter that `semanticTypes` or `semanticFilter` asks for; None lets every label pass.

    Raises:
        AnnotatorError: both are given, or one is of another type.
    """
    types, predicate = params.get("semanticTypes"), params.get("semanticFilter")
    names = [types] if types is None or isinstance(types, str) else types
    if not isinstance(names, (list, tuple, set)) or not all(name is None or isinstance(name, str) for name in names):
        raise AnnotatorError(f"semanticTypes is {types!r}; expected a list of types such as ['class'].")
    if not isinstance(predicate, (str, type(None))):
        raise AnnotatorError(f"semanticFilter is {predicate!r}; expected a predicate such as 'class:*'.")
    if types and predicate:
        raise AnnotatorError("semanticTypes and semanticFilter exclude each other; give one.")
    if types:
        return ";".join(f"{kind}:*" for kind in names)
    return predicate or None
