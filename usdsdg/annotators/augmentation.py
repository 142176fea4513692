"""Augmentations: functions that annotators pass their array through. Python functions work; graph nodes do not."""

from __future__ import annotations

import inspect
import zlib
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import Annotation
from usdsdg.annotators.frame import Frame
from usdsdg.errors import AnnotatorRegistryError, AugmentationError, Unsupported
from usdsdg.registry import Registry

augmentations: Registry[Augmentation] = Registry("augmentation", AnnotatorRegistryError)


class Augmentation:
    """A function of an annotator's array, with fixed keyword arguments."""

    def __init__(
        self, node_type_id: str, data_out_shape: Any = None, documentation: str | None = None, **kwargs: Any
    ) -> None:
        raise Unsupported(
            f"Augmentation node {node_type_id!r}: there is no OmniGraph here. Write it as a Python function of data_in "
            "and use Augmentation.from_function."
        )

    @classmethod
    def from_function(
        cls,
        augmentation: Callable[..., np.ndarray],
        data_out_shape: Any = None,
        documentation: str | None = None,
        **kwargs: Any,
    ) -> Augmentation:
        """An augmentation that calls `augmentation(data_in, **kwargs)`, with `seed` too if the function takes it.

        data_out_shape: shape the result must have; -1 keeps that axis of the input. None: any.

        Raises:
            Unsupported: it is a Warp kernel.
        """
        if not callable(augmentation) or type(augmentation).__module__.partition(".")[0] == "warp":
            raise Unsupported(
                f"Augmentation {getattr(augmentation, 'key', augmentation)!r} is not a Python function: Warp "
                "kernels are not run yet. Write it with NumPy: a function of data_in that returns an array."
            )
        made = object.__new__(cls)
        made._function, made._shape, made._kwargs = augmentation, data_out_shape, dict(kwargs)
        made.documentation = documentation or inspect.getdoc(augmentation) or ""
        return made

    @classmethod
    def from_node(cls, node_type_id: str, attributes_mapping: Any = None, **kwargs: Any) -> Augmentation:
        """Unsupported: there are no nodes to augment with."""
        return cls(node_type_id, **kwargs)

    _function: Callable[..., np.ndarray]
    _shape: Any
    _kwargs: Mapping[str, Any]
    documentation: str

    def with_arguments(self, data_out_shape: Any, kwargs: Mapping[str, Any]) -> Augmentation:
        """The same function with other keyword arguments added."""
        shape = self._shape if data_out_shape is None else data_out_shape
        return Augmentation.from_function(self._function, shape, self.documentation, **{**self._kwargs, **kwargs})

    def apply(self, annotator: Any, name: str | None = None, **kwargs: Any) -> Any:
        """A new annotator: `annotator` (object or name) passed through this augmentation."""
        from usdsdg.annotators.catalogue import augment

        return augment(annotator, self, name=name, **kwargs)

    def run(self, annotation: Annotation, frame: Frame) -> Annotation:
        """The annotation with its array passed through.

        Raises:
            AugmentationError: there is no array, the function failed, or the result is not an array of the right shape.
        """
        label = getattr(self._function, "__name__", repr(self._function))
        if annotation.data is None:
            raise AugmentationError(f"Augmentation {label} was given an annotator without an array.")
        kwargs = dict(self._kwargs)
        if "seed" in _parameters(self._function) and kwargs.get("seed") in (None, -1):
            # Keyed by the frame and the render product: no generator is shared between frames.
            kwargs["seed"] = zlib.crc32(f"{frame.render_product} {frame.index}".encode())
        try:
            # A copy, because functions may write in place and the frame's arrays are shared.
            result = self._function(annotation.data.copy(), **kwargs)
        except Exception as error:
            raise AugmentationError(f"Augmentation {label} failed on {annotation.data.shape}: {error}") from error
        return Annotation(self._checked(result, annotation.data, label), annotation.info)

    def _checked(self, result: Any, data: np.ndarray, label: str) -> np.ndarray:
        if not isinstance(result, np.ndarray):
            raise AugmentationError(f"Augmentation {label} returned {type(result).__name__}; it must return an array.")
        if self._shape is not None:
            wanted = tuple(
                data.shape[axis] if size == -1 and axis < data.ndim else size for axis, size in enumerate(self._shape)
            )
            if result.shape != wanted:
                raise AugmentationError(
                    f"Augmentation {label} returned shape {result.shape}, data_out_shape is {wanted}."
                )
        return result


def _parameters(function: Callable) -> Mapping[str, inspect.Parameter]:
    try:
        return inspect.signature(function).parameters
    except (TypeError, ValueError):  # built-ins need not have one
        return {}


def as_augmentation(augmentation: Any, data_out_shape: Any, kwargs: Mapping[str, Any]) -> Augmentation:
    """An `Augmentation` from one, from its registered name, or from a function."""
    if isinstance(augmentation, str):
        augmentation = augmentations.get(augmentation)
    if not isinstance(augmentation, Augmentation):
        return Augmentation.from_function(augmentation, data_out_shape, **kwargs)
    return augmentation.with_arguments(data_out_shape, kwargs)


def _rgba_to_rgb(data_in: np.ndarray) -> np.ndarray:
    """Drop alpha."""
    return np.ascontiguousarray(data_in[..., :3])


for _name in ("rgba_to_rgb", "RgbaToRgb"):
    augmentations.add(_name, Augmentation.from_function(_rgba_to_rgb))
