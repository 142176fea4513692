"""Annotators by name: `rep.annotators.get`, `register`, `augment` and their like."""

from collections.abc import Mapping, Sequence
from typing import Any

from usdsdg.annotators.annotator import Annotator
from usdsdg.annotators.base import annotator_specs
from usdsdg.arguments.registry import Registry
from usdsdg.errors import AnnotatorRegistryError, Unsupported

# Names that Replicator has and usdsdg does not, with the reason that the error gives.
UNSUPPORTED: dict[str, str] = dict.fromkeys(
    ("RtxSensorCpu", "RtxSensorGpu", "GenericModelOutput", "RtxSensorMetadata", "StableIdMap"),
    "lidar and radar are out of scope",
)

# Annotators that scripts register with their parameters and augmentations; `get` copies them.
registered_annotators: Registry[Annotator] = Registry("annotator", AnnotatorRegistryError)


def get(
    name: str,
    init_params: Mapping[str, Any] | None = None,
    render_product_idxs: Sequence[int] | None = None,
    device: str | None = None,
    do_array_copy: bool = True,
) -> Annotator:
    """Return a new, unattached annotator.

    Args:
        name: of a built-in or registered annotator.
        init_params: see `Annotator.initialize`.
        render_product_idxs: which of the render products that a writer, or the annotator, is attached to it watches;
            by default all of a writer's.
        device: "cpu" or None to get NumPy arrays from `get_data`, "cuda[:n]" to get Warp arrays;
            see `Annotator.get_data`.
        do_array_copy: whether `get_data` returns, and writers receive, a copy, which may be written into.

    Raises:
        AnnotatorRegistryError: there is no such annotator; the message lists near misses.
        Unsupported: Replicator has it and usdsdg does not.
    """
    if name in registered_annotators:
        found = registered_annotators.get(name).copy(device=device, do_array_copy=do_array_copy)
        if render_product_idxs is not None:
            found.choose_products(render_product_idxs)
        return found.initialize(**init_params) if init_params else found
    if name in UNSUPPORTED and name not in annotator_specs:
        raise Unsupported(f"Annotator {name!r}: {UNSUPPORTED[name]}.")
    return Annotator(
        annotator_specs.get(name), init_params=init_params, device=device, do_array_copy=do_array_copy,
        render_product_idxs=render_product_idxs,
    )  # fmt: skip


def get_registered_annotators() -> list[str]:
    """Return the names of all annotators that `get` knows, those registered by scripts last."""
    return [*annotator_specs.names(), *registered_annotators.names()]


def register(name: str, annotator: Annotator | str) -> None:
    """Register an (augmented) annotator, or a registered one by its name, under `name`; replaces an earlier one.

    Raises:
        AnnotatorRegistryError: `annotator` is neither an annotator nor the name of one.
    """
    if isinstance(annotator, str):
        annotator = get(annotator)
    if not isinstance(annotator, Annotator):
        raise AnnotatorRegistryError(f"register({name!r}, ...): {annotator!r} is not an Annotator.")
    registered_annotators.add(name, annotator.copy(name))


def unregister_annotator(name: str) -> None:
    """Remove an annotator from the registry.

    Raises:
        AnnotatorRegistryError: there is no such annotator; the message lists near misses.
    """
    (registered_annotators if name in registered_annotators else annotator_specs).remove(name)


def augment(
    source_annotator: Annotator | str,
    augmentation: Any,
    data_out_shape: Any = None,
    name: str | None = None,
    device: Any = None,
    **kwargs: Any,
) -> Annotator:
    """Return a new annotator: `source_annotator` (object or name) with `augmentation` applied to its array.

    See `Annotator.augment` for the arguments and errors; the source does not change.
    """
    source = get(source_annotator) if isinstance(source_annotator, str) else source_annotator.copy()
    return source.augment(augmentation, data_out_shape, name, device, **kwargs)


def augment_compose(
    source_annotator: Annotator | str, augmentations: Sequence[Any], name: str | None = None
) -> Annotator:
    """Return a new annotator: `source_annotator` (object or name) with several augmentations applied in turn.

    See `Annotator.augment_compose` for errors; the source does not change.
    """
    source = get(source_annotator) if isinstance(source_annotator, str) else source_annotator.copy()
    return source.augment_compose(augmentations, name)
