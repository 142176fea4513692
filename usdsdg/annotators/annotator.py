"""The object users hold: one use of an annotator, with its parameters, augmentations and render product."""

from __future__ import annotations

import copy
import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from usdsdg.annotators.augmentations.array_transform import ArrayTransform
from usdsdg.annotators.augmentations.warp_kernel import device_or_cpu
from usdsdg.annotators.base import Annotation, AnnotatorSpec, predicate_of
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.ownership import parse_filter
from usdsdg.annotators.render_products import existing_products, render_product_paths
from usdsdg.arguments.registry import near_misses
from usdsdg.errors import AnnotatorError, Unsupported
from usdsdg.session.session import current


class Annotator:
    """One use of an annotator: its parameters, its augmentations, the render product it watches."""

    def __init__(
        self,
        spec: AnnotatorSpec,
        *,
        name: str | None = None,
        init_params: Mapping[str, Any] | None = None,
        device: str | None = None,
        do_array_copy: bool = True,
    ) -> None:
        self._spec = spec
        self._device = device
        self._copies = do_array_copy
        self._name = name or spec.name
        self._params: dict[str, Any] = dict(spec.params)
        self._augmentations: list[ArrayTransform] = []
        self._render_product: str | None = None
        self._latest: Annotation | None = None
        if init_params:
            self.initialize(**init_params)

    # What the orchestrator asks

    @property
    def aovs(self) -> frozenset[str]:
        """AOVs that the renderer must make for it."""
        return self._spec.aovs.union(*(augmentation.aovs for augmentation in self._augmentations))

    @property
    def needs_amodal_masks(self) -> bool:
        """Whether it reads `Frame.amodal_masks`."""
        return self._spec.needs_amodal_masks

    @property
    def needs_path_tracing(self) -> bool:
        """Whether it reads path-traced colour ("LdrColor", "HdrColor")."""
        return self._spec.needs_path_tracing

    @property
    def label_filter(self) -> str | None:
        """The label filter to announce to `LabeledPrimReader.read`."""
        return predicate_of(self._params)

    @property
    def render_product(self) -> str | None:
        """Path of the render product it is attached to."""
        return self._render_product

    def compute(self, frame: Frame) -> Annotation:
        """What it says of `frame`, augmentations applied; also what `get_data` returns from now on."""
        key = ("annotation", self._spec.compute, json.dumps(self._params, sort_keys=True, default=str))
        annotation = frame.derive(key, lambda: self._spec.compute(frame, self._params))
        twins: Counter[str] = Counter()
        for augmentation in self._augmentations:
            # What draws depend on: others may be added before and after without changing them.
            key = f"{frame.render_product}/{self._name}/{augmentation.label}#{twins[augmentation.label]}"
            twins[augmentation.label] += 1
            annotation = augmentation.run(annotation, frame, key=key, device=self._device)
        self._latest = annotation
        return annotation

    # What users call

    def initialize(self, **init_params: Any) -> Annotator:
        """Set init parameters; only before attaching.

        Raises:
            AnnotatorError: it is attached, has no such parameter, two exclude each other, or a value does not fit.
            ConfigError: the label filter does not follow the grammar.
        """
        if self._render_product is not None:
            raise AnnotatorError(f"{self._name} is attached to {self._render_product}: detach it before initialize().")
        for key in init_params:
            if key not in self._spec.params:
                close = near_misses(key, self._spec.params)
                known = ", ".join(self._spec.params) or "none"
                hint = f"Did you mean {close[0]!r}?" if close else f"It has: {known}."
                raise AnnotatorError(f"Annotator {self._name!r} has no init parameter {key!r}. {hint}")
            given, switch = init_params[key], isinstance(self._spec.params[key], bool)
            if switch and not isinstance(given, (bool, np.bool_)) and given not in (0, 1):
                raise AnnotatorError(f"Annotator {self._name!r}: {key} is {given!r}; expected True or False.")
        self._params.update(init_params)
        parse_filter(predicate_of(self._params))
        return self

    def attach(self, render_products: Any, render_product_idxs: Any = None) -> Annotator:
        """Watch one render product (an object with `.path`, a path, or a list of one).

        `render_product_idxs` changes nothing: there is only one.

        Raises:
            BadPrim: there is no such render product, or none any more.
            Unsupported: several render products.
        """
        paths = existing_products(render_products)
        if len(paths) != 1:
            raise Unsupported(
                f"Annotator {self._name!r} was given {len(paths)} render products: attach one annotator to each."
            )
        self._render_product = paths[0]
        if self not in current().annotators:
            current().annotators.append(self)
        if self._spec.on_attach is not None:
            self._spec.on_attach(self)
        return self

    def bind(self, render_product: str | None) -> None:
        """Belong to a writer that watches `render_product`, and is the one to compute; None: not any more."""
        if self not in current().annotators:
            self._render_product = render_product
            self._latest = self._latest if render_product else None

    def detach(self, render_products: Any = None) -> Annotator:
        """Stop watching; `render_products`, if given, says which one."""
        if render_products is None or self._render_product in render_product_paths(render_products):
            self._render_product = None
            self._latest = None
            if self in current().annotators:
                current().annotators.remove(self)
        return self

    def get_data(
        self, device: str | None = None, do_array_copy: bool = False, use_legacy_structure: bool = True
    ) -> Any:
        """What it said of the latest frame; arrays of size 0 before the first.

        device: "cpu" gives a NumPy array, "cuda[:n]" a Warp array (on the CPU where there is no such device); None
            takes what the annotator was made with.
        do_array_copy: give an array of the caller's own, also where the annotator was made with do_array_copy=False.
            Without, the array is shared with the writers and must not be written into.

        Raises:
            AnnotatorError: it is not attached.
        """
        if self._render_product is None:
            raise AnnotatorError(f"Annotator {self._name!r} is not attached. Call attach(render_product) first.")
        latest = self._latest or Annotation(self._spec.empty)
        data = latest.data
        device = device or self._device
        if data is not None and device not in (None, "cpu"):
            import warp

            # Warp has no unsigned 32-bit textures of ids in Replicator either; ids stay below 2**31.
            data = warp.array(data.view(np.int32) if data.dtype == np.uint32 else data, device=device_or_cpu(device))
        elif data is not None and (do_array_copy or self._copies):
            data = data.copy()
        latest = Annotation(data, latest.info)
        return latest.legacy() if use_legacy_structure else latest.flat()

    def augment(
        self, augmentation: Any, data_out_shape: Any = None, name: str | None = None, device: Any = None, **kwargs: Any
    ) -> Annotator:
        """Pass the array through `augmentation` too, from now on; returns the annotator itself.

        Args:
            augmentation: an Augmentation, its registered name, the type of a node, or a function.
            data_out_shape: shape of the result; -1 keeps that axis of the input.
            name: of the annotator from now on: its key in a writer's payload. None: as before.
            device: where kernels run and what `get_data` gives; None: as before.
            kwargs: arguments of the augmentation; see `Augmentation.from_function`.

        Raises:
            AnnotatorRegistryError: there is no augmentation of that name.
            AugmentationError: it takes no such argument, or needs one that is not there.
        """
        self._augmentations.append(ArrayTransform.of(augmentation).with_arguments(data_out_shape, kwargs))
        self._name = name or self._name
        self._device = device or self._device
        return self

    def augment_compose(self, augmentations: Sequence[Any], name: str | None = None) -> Annotator:
        """Pass the array through several augmentations too, one after the other; returns the annotator itself.

        Raises:
            as `augment`; then none of them is applied.
        """
        self._augmentations += [ArrayTransform.of(each).with_arguments(None, {}) for each in augmentations]
        self._name = name or self._name
        return self

    def copy(self, name: str | None = None, *, device: str | None = None) -> Annotator:
        """An unattached annotator with the same parameters and augmentations."""
        twin = copy.copy(self)
        twin._name, twin._device = name or self._name, device or self._device
        twin._params, twin._augmentations = dict(self._params), list(self._augmentations)
        twin._render_product = twin._latest = None
        return twin

    def get_name(self) -> str:
        """What it is called: its key in a writer's payload."""
        return self._name

    def get_node(self) -> Annotator:
        """An opaque handle: there is no OmniGraph node behind an annotator."""
        return self

    @property
    def name(self) -> str:
        """As `get_name`."""
        return self._name

    @property
    def template_name(self) -> str:
        """The name that its kind was registered under, whatever it is called itself."""
        return self._spec.name

    @property
    def is_attached(self) -> bool:
        """Whether it watches a render product."""
        return self._render_product is not None

    @property
    def documentation(self) -> str:
        """What it gives: shape, type, units, parameters."""
        return self._spec.documentation


def attached_annotators() -> tuple[Annotator, ...]:
    """Annotators that users attached to render products themselves; those of writers are the writers'."""
    return tuple(current().annotators)


def detach_all() -> None:
    """Detach every annotator, as for a new stage."""
    for annotator in attached_annotators():
        annotator.detach()


@dataclass(frozen=True)
class Requirements:
    """What a set of annotators needs of one frame."""

    aovs: frozenset[str] = frozenset()
    amodal_masks: bool = False
    path_tracing: bool = False
    filters: tuple[str | None, ...] = ()


def requirements(annotators: Iterable[Annotator]) -> Requirements:
    """The union of what `annotators` need."""
    annotators = list(annotators)
    return Requirements(
        frozenset().union(*(a.aovs for a in annotators)),
        any(a.needs_amodal_masks for a in annotators),
        any(a.needs_path_tracing for a in annotators),
        tuple(dict.fromkeys(a.label_filter for a in annotators)),
    )
