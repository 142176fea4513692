"""The object that users hold: an annotator bound to parameters, augmentations and a render product."""

from __future__ import annotations

import copy
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from usdsdg.annotators.augmentations.array_transform import ArrayTransform
from usdsdg.annotators.base import Annotation, AnnotatorSpec, predicate_of
from usdsdg.annotators.delivery import Delivery, checked_device, delivered
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.ownership import parse_filter
from usdsdg.annotators.packed_colors import packed
from usdsdg.annotators.render_products import chosen_products, existing_products, render_product_paths
from usdsdg.arguments.registry import near_misses
from usdsdg.errors import AnnotatorError, AnnotatorRegistryError, ArgumentError, Unsupported, warn_once
from usdsdg.session.session import current
from usdsdg.session.settings.replicator_version import OLD, replicator_version
from usdsdg.session.turns import in_turn


class Annotator:
    """An annotator with its parameters and augmentations, attached to a render product or not yet."""

    def __init__(
        self,
        spec: AnnotatorSpec,
        *,
        name: str | None = None,
        init_params: Mapping[str, Any] | None = None,
        device: str | None = None,
        do_array_copy: bool = True,
        render_product_idxs: Sequence[int] | None = None,
    ) -> None:
        self._spec = spec
        self._render_product_idxs = None if render_product_idxs is None else tuple(render_product_idxs)
        self._delivery = Delivery(_device(device), copies=do_array_copy)
        self._name = name or spec.name
        self._params: dict[str, Any] = dict(spec.params)
        self._augmentations: list[ArrayTransform] = []
        self._render_product: str | None = None
        self._is_detachable = False  # attached, and not detached by its user since
        self._latest: Annotation | None = None
        if init_params:
            self.initialize(**init_params)

    # For the capture

    @property
    def aovs(self) -> frozenset[str]:
        """The AOVs that it needs rendered."""
        return self._spec.aovs.union(*(augmentation.aovs for augmentation in self._augmentations))

    @property
    def spec(self) -> AnnotatorSpec:
        """What it was created from, which says what it needs rendered beside AOVs."""
        return self._spec

    @property
    def earlier_captures(self) -> int:
        """How many captures ago the earliest picture was whose points it follows."""
        return int(self._params.get("captures", 0))

    @property
    def reads_labels(self) -> bool:
        """Whether it has nothing to show where no labeled prim is in view."""
        return "semanticTypes" in self._spec.params and "instance_id" not in self._spec.name

    @property
    def label_filter(self) -> str | None:
        """The label filter to pass to `LabeledPrimReader.read`."""
        return predicate_of(self._params)

    @property
    def parameters(self) -> dict[str, Any]:
        """Its init parameters by name."""
        return dict(self._params)

    @property
    def augmentations(self) -> list[str]:
        """The names of what is applied to its array, in order."""
        return [augmentation.label for augmentation in self._augmentations]

    @property
    def device(self) -> str | None:
        """The device that it was created with: None or "cpu" for NumPy arrays, else that of its Warp arrays."""
        return self._delivery.device

    @property
    def delivery(self) -> Delivery:
        """Where its arrays are delivered, and whether they are copies."""
        return self._delivery

    @property
    def render_product(self) -> str | None:
        """The path of the render product that it is attached to."""
        return self._render_product

    @property
    def has_data(self) -> bool:
        """Whether a frame has been computed since it was attached."""
        return self._latest is not None

    def compute(self, frame: Frame) -> Annotation:
        """Compute the annotation of `frame`, augmentations applied, and keep it for `get_data`."""
        key = self._spec.key_of(self._params)
        annotation = frame.derive(key, lambda: self._spec.annotate(frame, self._params))
        if self._params.get("colorize") and annotation.data is not None and replicator_version() == OLD:
            annotation = Annotation(packed(frame.on_host(annotation.data)), annotation.info)
        counts: Counter[str] = Counter()
        device = self._delivery.warp_device() if self._augmentations else None
        for augmentation in self._augmentations:
            # Random draws depend on this key, so that adding other augmentations does not change them.
            key = f"{frame.render_product}/{self._name}/{augmentation.label}#{counts[augmentation.label]}"
            counts[augmentation.label] += 1
            annotation = augmentation.run(annotation, frame, key=key, device=device)
        self._latest = annotation
        return annotation

    def held(self) -> Annotation | None:
        """Return the latest annotation, in NumPy arrays that must not be written into; None before the first frame."""
        if self._latest is None:
            return None
        current().wait_for_pictures()
        return delivered(self._latest, None, copy=False, copy_tables=False)

    def _repr_html_(self) -> str:
        from usdsdg.notebook.annotators import annotator_html

        return annotator_html(self)

    def _repr_png_(self) -> bytes | None:
        from usdsdg.notebook.annotators import annotator_png

        return annotator_png(self)

    # For users

    def initialize(self, **init_params: Any) -> Annotator:
        """Set init parameters; only before attaching.

        Raises:
            AnnotatorRegistryError: it is attached.
            AnnotatorError: it has no such parameter, two exclude each other, or one is invalid.
            ConfigError: the label filter cannot be parsed.
        """
        if self._render_product is not None:
            raise AnnotatorRegistryError(
                f"{self._name} is attached to {self._render_product}: detach it before initialize()."
            )
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
        if self._spec.check is not None:
            self._spec.check(self._params)
        return self

    def attach(self, render_products: Any, render_product_idxs: Any = None) -> Annotator:
        """Attach to one render product (an object with `.path`, a path, or a list of one).

        Of several products `render_product_idxs`, by default those that the annotator was made with, choose one.

        Raises:
            ArgumentError: there is no render product, or none with such an index.
            BadPrim: the render product does not exist.
            Unsupported: several render products.
        """
        paths = existing_products(render_products)
        if not paths:
            raise ArgumentError(f"Annotator {self._name!r} was given no render product; attach it to one.")
        chosen = self._render_product_idxs if render_product_idxs is None else tuple(render_product_idxs)
        if len(paths) > 1 and chosen is not None:
            paths = chosen_products(paths, chosen, self._name)
        if len(paths) != 1:
            raise Unsupported(
                f"Annotator {self._name!r} was given {len(paths)} render products: attach one annotator to each."
            )
        if paths[0] != self._render_product:
            self._latest = None  # of another render product
        self._render_product, self._is_detachable = paths[0], True
        if self not in current().annotators:
            current().annotators.append(self)
        current().live.note(self)
        if self._spec.on_attach is not None:
            try:
                self._spec.on_attach(self)
            except Exception:
                self.detach()
                raise
        return self

    def choose_products(self, render_product_idxs: Sequence[int]) -> None:
        """Watch these of the render products of a writer from now on."""
        self._render_product_idxs = tuple(render_product_idxs)

    def chosen_of(self, render_products: Sequence[str]) -> list[str]:
        """Return the render products of a writer that it watches: all, or those of its `render_product_idxs`.

        Raises:
            ArgumentError: there is none with such an index.
        """
        if self._render_product_idxs is None:
            return list(render_products)
        return chosen_products(render_products, self._render_product_idxs, self._name)

    def bind(self, render_product: str | None) -> None:
        """Bind to the render product of a writer, which then computes it; None unbinds."""
        if self not in current().annotators:
            self._render_product, self._is_detachable = render_product, render_product is not None
            self._latest = self._latest if render_product else None

    def detach(self, render_products: Any = None) -> Annotator:
        """Detach from its render product; with `render_products` only if it is among them.

        Raises:
            AnnotatorError: no `render_products` are given, and it is not attached. One that a new stage has detached
                may still be.
        """
        if render_products is None and not self._is_detachable:
            raise AnnotatorError(
                f"Annotator {self._name!r} is attached to no render product, so it cannot be detached."
            )
        if render_products is None or self._render_product in render_product_paths(render_products):
            self._is_detachable = False
            self.release()
        return self

    def release(self) -> None:
        """Detach on behalf of something other than its user: of a new stage."""
        self._render_product = self._latest = None
        if self in current().annotators:
            current().annotators.remove(self)

    @in_turn
    def get_data(
        self, device: str | None = None, do_array_copy: bool = False, use_legacy_structure: bool = True
    ) -> Any:
        """Return the annotation of the latest captured frame, or of the stage as the latest update of the application
        shows it, whichever is later. Before the first arrays have size 0, and info has the same keys as later.

        device: "cpu" returns a NumPy array, "cuda[:n]" a Warp array (on the CPU if there is no such device), which
            PyTorch, JAX and CuPy take over without a copy (DLPack); records such as boxes, and info, are NumPy arrays
            in any case. None uses the device that the annotator was created with; without one, images that a Warp
            kernel has augmented are Warp arrays on the renderer's device, as in Replicator.
        do_array_copy: copy the array, even if the annotator was created with do_array_copy=False. Without a copy the
            array is shared with the writers, must not be written into, and may be used until the next frame.

        Raises:
            AnnotatorError: it is not attached.
            ArgumentError: (a ValueError) there can be no such device.
        """
        device = checked_device(device)
        if self._render_product is None:
            raise AnnotatorError(f"Annotator {self._name!r} is not attached. Call attach(render_product) first.")
        if self in current().annotators:
            current().live.refresh(self)
        current().wait_for_pictures()
        if self._latest is None:
            warn_once(
                f"annotator {self._name!r} has no frame yet, so it is empty; rep.orchestrator.step() captures one"
            )
        copy = do_array_copy or self._delivery.copies
        warp_device = self._delivery.warp_device() if device is None else None if device == "cpu" else device
        latest = delivered(self._latest or self._spec.before_first_frame(), warp_device, copy=copy)
        return latest.legacy() if use_legacy_structure else latest.flat()

    def augment(
        self, augmentation: Any, data_out_shape: Any = None, name: str | None = None, device: Any = None, **kwargs: Any
    ) -> Annotator:
        """Apply `augmentation` to the array too, from now on; returns the annotator itself.

        Args:
            augmentation: an Augmentation, its registered name, the type of a node, or a function.
            data_out_shape: shape of the result; -1 keeps that axis of the input.
            name: new name of the annotator, its key in a writer's payload. None: unchanged.
            device: where kernels run and `get_data` returns arrays; None: unchanged, and for a Warp kernel the
                renderer's device if the annotator has none.
            kwargs: arguments of the augmentation; see `Augmentation.from_function`.

        Raises:
            NoAugmentation: there is no augmentation of that name.
            AugmentationError: it is neither that nor a function nor a kernel, or a required argument is missing.
        """
        device = _device(device)
        transform = ArrayTransform.of(augmentation).with_arguments(data_out_shape, kwargs)
        self._augmentations.append(transform)
        self._delivery = self._delivery.augmented([transform], device)
        self._name = name or self._name
        return self

    def augment_compose(self, augmentations: Sequence[Any], name: str | None = None) -> Annotator:
        """Apply several augmentations to the array in turn, from now on; returns the annotator itself.

        Raises:
            as `augment`; in that case none of them is added.
        """
        transforms = [ArrayTransform.of(each).with_arguments(None, {}) for each in augmentations]
        self._augmentations += transforms
        self._delivery = self._delivery.augmented(transforms)
        self._name = name or self._name
        return self

    def on_its_device(self) -> Annotator:
        """Deliver arrays where `device` says from now on, also those of Warp kernels; returns the annotator itself."""
        self._delivery = replace(self._delivery, is_moved=False)
        return self

    def copy(self, name: str | None = None, *, device: str | None = None, do_array_copy: bool = True) -> Annotator:
        """Return an unattached annotator with the same parameters and augmentations.

        It copies arrays if this one does and `do_array_copy` is True.
        """
        twin = copy.copy(self)
        twin._name = name or self._name
        twin._delivery = self._delivery.of_copy(_device(device), do_array_copy)
        twin._params, twin._augmentations = dict(self._params), list(self._augmentations)
        twin._render_product = twin._latest = None
        twin._is_detachable = False
        return twin

    def get_name(self) -> str:
        """Return its name: its key in a writer's payload."""
        return self._name

    def get_node(self) -> Annotator:
        """Return the annotator itself as an opaque handle: there is no OmniGraph node behind it.

        Raises:
            AnnotatorRegistryError: it is not attached.
        """
        if self._render_product is None:
            raise AnnotatorRegistryError(f"Annotator {self._name!r} is attached to no render product, so has no node.")
        return self

    @property
    def name(self) -> str:
        """As `get_name`."""
        return self._name

    @property
    def template_name(self) -> str:
        """The name of the registered annotator that it was created from."""
        return self._spec.name

    @property
    def is_color_image(self) -> bool:
        """Whether it passes the path-traced color image on as it is."""
        return self.template_name in ("rgb", "LdrColor") and not self._augmentations

    @property
    def is_attached(self) -> bool:
        """Whether it is attached to a render product."""
        return self._render_product is not None

    @property
    def documentation(self) -> str:
        """The documentation of its output: shape, type, units, parameters."""
        return self._spec.documentation

    @property
    def docs(self) -> str:
        """As `documentation`."""
        return self._spec.documentation


def _device(device: Any) -> str | None:
    """Check the device of an annotator.

    Raises:
        AnnotatorRegistryError: it is neither None, "cpu", "cuda" nor "cuda:<number>".
    """
    try:
        return checked_device(device)
    except ArgumentError as error:
        raise AnnotatorRegistryError(str(error)) from None


def attached_annotators() -> tuple[Annotator, ...]:
    """Return the annotators that users attached to render products; those of writers are not included."""
    return tuple(current().annotators)


def detach_all() -> None:
    """Detach every annotator, as for a new stage."""
    for annotator in attached_annotators():
        annotator.release()
