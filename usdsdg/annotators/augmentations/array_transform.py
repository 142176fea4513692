"""The function that an augmentation applies to an annotator's array, with its arguments.

It is a Python function of `data_in`, a Warp kernel from `data_in` to `data_out`, or one of Replicator's augmentation
nodes by name (defaults.py). Arguments are constants, or distributions that are sampled for every frame; `seed` depends
on (seed, annotator, augmentation, frame) alone, so that runs are reproducible.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Self, TypeVar

import numpy as np

from usdsdg.annotators.augmentations.signatures import (
    arguments_of,
    gives_warp_array,
    has_data_in,
    is_kernel,
    unknown_argument,
)
from usdsdg.annotators.augmentations.warp_kernel import launch
from usdsdg.annotators.base import Annotation
from usdsdg.annotators.frame import Frame
from usdsdg.arguments.registry import Registry, near_misses
from usdsdg.errors import AnnotatorRegistryError, AugmentationError, NoAugmentation, Unsupported, note_line, warn_once
from usdsdg.graph.sampling import get_global_seed, own_seed, uniforms

# Seeds lie below this, the range that every generator accepts.
SEEDS = 2**31 - 1


class Warped(NamedTuple):
    """The result of an augmentation that moves pixels."""

    data: np.ndarray
    xform: np.ndarray  # (3, 3): (x, y, 1) in pixels of the result = xform @ (x, y, 1) in pixels of the input


@dataclass(frozen=True)
class NodeSpec:
    """One of Replicator's augmentation nodes: the equivalent function, and the AOVs that it also reads."""

    function: Callable[..., Any]
    aovs: Mapping[str, str] = field(default_factory=dict)  # argument of the function → AOV


node_specs: Registry[NodeSpec] = Registry("augmentation node", AnnotatorRegistryError)
augmentations: Registry[ArrayTransform] = Registry("augmentation", NoAugmentation)
AugmentationT = TypeVar("AugmentationT", bound="ArrayTransform")


class Seed(int):
    """A seed that may be added to an array of small integers, which then gets the type that holds both.

    NumPy 2 refuses such a number of Python; NumPy 1, which Replicator's scripts are written for, does this.
    """

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        integers = all(np.asarray(each).dtype.kind in "biu" for each in inputs)
        least = np.min_scalar_type(int(self)).type if integers else int
        return getattr(ufunc, method)(*(least(each) if isinstance(each, Seed) else each for each in inputs), **kwargs)


class ArrayTransform:
    """A function of an annotator's array, with its arguments."""

    _function: Any
    _shape: tuple[int, ...] | None
    _kwargs: Mapping[str, Any]
    _aovs: Mapping[str, str]
    _is_node: bool
    documentation: str

    def __init__(
        self, node_type_id: Any, data_out_shape: Any = None, documentation: str | None = None, **kwargs: Any
    ) -> None:
        """Wrap the node of type `node_type_id` ("omni.replicator.core.AugRotateExp"), or a function.

        Raises:
            Unsupported: there is no such node.
        """
        spec = NodeSpec(node_type_id) if callable(node_type_id) else _node_spec(node_type_id)
        self._set(spec.function, data_out_shape, documentation, kwargs, spec.aovs, not callable(node_type_id))

    @classmethod
    def from_function(
        cls: type[AugmentationT],
        augmentation: Any,
        data_out_shape: Any = None,
        documentation: str | None = None,
        **kwargs: Any,
    ) -> AugmentationT:
        """Wrap a Python function, or a Warp kernel that is launched with one thread per pixel.

        A function is called as `augmentation(data_in=array, **kwargs)` and returns an array; it may write into
        `data_in`, which is a copy. A kernel has the arrays `data_in` and `data_out`, which is initially zero. Both get
        `seed`, an integer from 0 to 2**31 - 2 that differs from frame to frame, if they have an argument of that name.

        Args:
            augmentation: the function or kernel.
            data_out_shape: shape of the result; -1 keeps that axis of the input, and (-1, 4) may stand for all pixels
                with 4 channels. None: any for a function, that of the input for a kernel.
            documentation: default, the docstring.
            kwargs: its other arguments: values, or distributions to sample at every frame; one that it does not have
                is ignored with a warning. `seed` is what its seeds are derived from; None or a negative one stands for
                the global seed.

        Raises:
            AugmentationError: `augmentation` is neither a function nor a kernel.
        """
        if not callable(augmentation) and not is_kernel(augmentation):
            raise AugmentationError(
                f"{augmentation!r} is no augmentation: give a Python function of data_in, or a Warp kernel with "
                "data_in and data_out."
            )
        made = object.__new__(cls)
        made._set(augmentation, data_out_shape, documentation, kwargs, {}, False)
        return made

    @classmethod
    def from_node(
        cls: type[AugmentationT],
        node_type_id: str,
        attributes_mapping: Any = None,
        data_out_shape: Any = None,
        documentation: str | None = None,
        **kwargs: Any,
    ) -> AugmentationT:
        """Wrap one of Replicator's augmentation nodes, such as "omni.replicator.core.AugContrastExp".

        attributes_mapping: ignored: no attributes have to be connected.

        Raises:
            Unsupported: there is no such node: nodes of other extensions do not exist here.
        """
        if attributes_mapping:
            warn_once(
                f"Augmentation.from_node({node_type_id!r}): attributes_mapping is ignored, there is no OmniGraph."
            )
        return cls(node_type_id, data_out_shape, documentation, **kwargs)

    def _set(
        self,
        function: Any,
        shape: Any,
        documentation: str | None,
        kwargs: Mapping[str, Any],
        aovs: Mapping[str, str],
        is_node: bool,
    ) -> None:
        self._function, self._kwargs, self._aovs, self._is_node = function, dict(kwargs), aovs, is_node
        self._shape = None if shape is None else tuple(int(size) for size in shape)
        self.documentation = documentation or inspect.getdoc(getattr(function, "func", function)) or ""
        known = arguments_of(function)
        if known is not None:
            for name in kwargs:
                if name not in known or name in ("data_in", "data_out"):
                    # Replicator lets these pass, and scripts give nodes several spellings of one argument.
                    warn_once(unknown_argument(self.label, name, known))
                    del self._kwargs[name]

    @classmethod
    def of(cls, augmentation: Any) -> ArrayTransform:
        """Resolve an augmentation, its registered name, the type of a node, or a function.

        Raises:
            NoAugmentation: there is no augmentation of that name.
            AugmentationError: it is neither a function nor a kernel.
            Unsupported: there is no such node.
        """
        if isinstance(augmentation, ArrayTransform):
            return augmentation
        if not isinstance(augmentation, str):
            return cls.from_function(augmentation)
        if augmentation not in augmentations and "." in augmentation:
            return cls.from_node(augmentation)
        return augmentations.get(augmentation)

    @property
    def label(self) -> str:
        """The function's name."""
        return getattr(self._function, "__name__", None) or getattr(self._function, "key", repr(self._function))

    @property
    def node_type_id(self) -> str:
        """The type of the node that Replicator runs it with."""
        if self._is_node:
            return f"omni.replicator.core.{next(name for name in node_specs if self._is_of(name))}"
        return f"omni.replicator.core.OgnAugment{'' if self.gives_warp_array else 'CPU'}"

    def _is_of(self, node: str) -> bool:
        return node_specs.get(node).function is self._function

    @property
    def data_out_shape(self) -> tuple[int, ...] | None:
        """The shape of the result as it was given, -1 for axes that are as long as those of the input."""
        return self._shape

    @property
    def gives_warp_array(self) -> bool:
        """Whether it is a Warp kernel, here or in Replicator: annotators then deliver Warp arrays."""
        return gives_warp_array(self._function)

    @property
    def aovs(self) -> frozenset[str]:
        """The AOVs that the function reads in addition to the array."""
        return frozenset(self._aovs.values())

    def with_arguments(self, data_out_shape: Any, kwargs: Mapping[str, Any]) -> Self:
        """Return a copy with more arguments.

        Raises:
            AugmentationError: a required one is missing.
        """
        made = object.__new__(type(self))
        shape = self._shape if data_out_shape is None else data_out_shape
        made._set(self._function, shape, self.documentation, {**self._kwargs, **kwargs}, self._aovs, self._is_node)
        given = {"data_in", "data_out", "seed", *self._aovs, *made._kwargs}
        missing = [
            name for name, needed in (arguments_of(self._function) or {}).items() if needed and name not in given
        ]
        if missing:
            raise AugmentationError(f"Augmentation {self.label} needs {', '.join(missing)}: give it as an argument.")
        return made

    def run(
        self, annotation: Annotation, frame: Frame, *, key: str | None = None, device: str | None = None
    ) -> Annotation:
        """Apply the function to the array of `annotation`.

        key: what random draws depend on besides the seed and the frame index; default, the render product and `label`.
        device: where kernels run; None or an unavailable one: on the CPU.

        Raises:
            AugmentationError: there is no array, the function failed, or the result is not an array of the right shape.
        """
        if annotation.data is None:
            raise AugmentationError(f"Augmentation {self.label} was given an annotator without an array.")
        data = frame.on_host(annotation.data)
        annotation = Annotation(data, annotation.info)
        key = f"{frame.render_product}/{self.label}" if key is None else key
        kwargs = {name: _drawn(value, f"{key}/{name}", frame) for name, value in self._kwargs.items()}
        kwargs |= {name: frame.aov(aov) for name, aov in self._aovs.items()}
        if "seed" in (arguments_of(self._function) or {}):
            seed = seed_of_frame(kwargs.get("seed"), key, frame.index)
            kwargs["seed"] = seed if is_kernel(self._function) else Seed(seed)
        try:
            result = self._call(data, kwargs, device)
        except AugmentationError:
            raise
        except Exception as error:
            failure = AugmentationError(
                f"Augmentation {self.label} failed on {data.dtype} of {data.shape}: {type(error).__name__}: {error}"
            )
            note_line(failure, error)
            raise failure from error
        return self._annotation(result, annotation)

    def _call(self, data: np.ndarray, kwargs: Mapping[str, Any], device: str | None) -> Any:
        if is_kernel(self._function):
            return launch(self._function, data, _shapes_of(self._shape, data) or [data.shape], kwargs, device)
        # Functions may write in place, and the frame's arrays are shared.
        if has_data_in(self._function):
            return self._function(data_in=data.copy(), **kwargs)
        return self._function(data.copy(), **kwargs)

    def _annotation(self, result: Any, before: Annotation) -> Annotation:
        assert before.data is not None
        info = dict(before.info)
        if self._is_node:
            moved = result.xform if isinstance(result, Warped) else np.eye(3)
            info["xform"] = (moved @ np.reshape(info.get("xform", np.eye(3)), (3, 3))).reshape(9)
        data = result.data if isinstance(result, Warped) else result
        if not isinstance(data, np.ndarray) and hasattr(data, "numpy"):  # a Warp array
            data = data.numpy()
        if not isinstance(data, np.ndarray):
            raise AugmentationError(
                f"Augmentation {self.label} returned {type(data).__name__}; it must return an array."
            )
        wanted = _shapes_of(self._shape, before.data)
        if wanted and data.shape not in wanted:
            raise AugmentationError(
                f"Augmentation {self.label} returned shape {data.shape}, data_out_shape is {wanted[0]}."
            )
        return Annotation(data, info)


def seed_of_frame(seed: Any, key: str, execution: int) -> int:
    """Derive the seed, an integer from 0 to 2**31 - 2, of one execution of what `key` names.

    seed: the augmentation's own; None or negative: the global one.
    """
    own = own_seed(seed)
    own = get_global_seed() if own is None else own
    return int(uniforms(own, key, execution, [""], 1)[0, 0] * SEEDS)


def _drawn(value: Any, key: str, frame: Frame) -> Any:
    """Return a constant as it is, or sample a distribution for this frame."""
    if not callable(getattr(value, "sample", None)):
        return value
    drawn = value.sample(key, frame.index, [frame.render_product])[0]
    return drawn.item() if isinstance(drawn, np.generic) else drawn


def _node_spec(node_type_id: str) -> NodeSpec:
    name = str(node_type_id).rsplit(".", 1)[-1].removeprefix("Ogn")
    if name not in node_specs:
        close = near_misses(name, node_specs)
        hint = f"Did you mean {' or '.join(close)}?" if close else f"There are: {', '.join(node_specs)}."
        raise Unsupported(
            f"Augmentation node {node_type_id!r}: there is no OmniGraph here, only Replicator's own augmentations. "
            f"{hint} Write others as a Python function of data_in and use Augmentation.from_function."
        )
    return node_specs.get(name)


def _shapes_of(shape: Sequence[int] | None, data: np.ndarray) -> list[tuple[int, ...]]:
    """Return the shapes that `shape` stands for: each -1 in it is the size of `data` along that axis.

    With fewer axes than `data`, a first -1 that is the only one may also be all pixels: (-1, 4) an image of 4 channels.
    """
    if shape is None:
        return []
    sizes = tuple(data.shape[axis] if size == -1 and axis < data.ndim else size for axis, size in enumerate(shape))
    channels = tuple(shape[1:])
    if shape[:1] == (-1,) and channels and -1 not in channels and len(shape) < data.ndim:
        return [sizes, (*data.shape[: -len(channels)], *channels)]
    return [sizes]
