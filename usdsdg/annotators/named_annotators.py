"""Annotators by name: `rep.annotators.get`, `register`, `augment` and their like."""

from collections.abc import Mapping, Sequence
from numbers import Integral
from typing import Any

from usdsdg.annotators.annotator import Annotator
from usdsdg.annotators.base import annotator_specs
from usdsdg.arguments.registry import Registry, near_misses
from usdsdg.errors import AnnotatorError, AnnotatorRegistryError, Unsupported, warn_once

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
        device: "cpu" or None to get NumPy arrays from `get_data`, unless a Warp kernel augments them, "cuda[:n]" to get
            Warp arrays; see `Annotator.get_data`.
        do_array_copy: whether `get_data` returns, and writers receive, a copy, which may be written into.

    Raises:
        AnnotatorRegistryError: there is no such annotator; the message lists near misses. Or another argument is of the
            wrong type.
        Unsupported: Replicator has it and usdsdg does not.
    """
    if init_params is not None and not isinstance(init_params, Mapping):
        raise AnnotatorRegistryError(f"Annotator {name!r}: init_params is {init_params!r}; expected a dictionary.")
    if isinstance(render_product_idxs, int):
        render_product_idxs = [render_product_idxs]
    if render_product_idxs is not None and not all(isinstance(each, Integral) for each in render_product_idxs):
        raise AnnotatorRegistryError(
            f"Annotator {name!r}: render_product_idxs is {render_product_idxs!r}; expected whole numbers."
        )
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
    registered_annotators.add(name, annotator.copy(name).on_its_device())


def unregister_annotator(name: str) -> None:
    """Remove an annotator from the registry; warns if there is none of that name.

    Raises:
        AnnotatorRegistryError: `name` is no text.
    """
    if not isinstance(name, str):
        raise AnnotatorRegistryError(f"unregister_annotator: {name!r} is no name.")
    if name not in registered_annotators and name not in annotator_specs:
        close = near_misses(name, get_registered_annotators())
        hint = f" Did you mean {' or '.join(map(repr, close))}?" if close else ""
        warn_once(f"unregister_annotator: no annotator is named {name!r}.{hint}")
        return
    (registered_annotators if name in registered_annotators else annotator_specs).remove(name)


def augment(
    source_annotator: Annotator | str,
    augmentation: Any,
    data_out_shape: Any = None,
    name: str | None = None,
    device: Any = None,
    **kwargs: Any,
) -> Annotator:
    """Apply `augmentation` to the array of an annotator, and return it: the object itself, or a new one for a name.

    See `Annotator.augment` for the arguments and errors. An attached annotator stays attached.
    """
    return _found(source_annotator).augment(augmentation, data_out_shape, name, device, **kwargs)


def augment_compose(
    source_annotator: Annotator | str, augmentations: Sequence[Any], name: str | None = None
) -> Annotator:
    """Apply several augmentations in turn, and return the annotator: the object itself, or a new one for a name.

    See `Annotator.augment_compose` for errors. An attached annotator stays attached.
    """
    return _found(source_annotator).augment_compose(augmentations, name)


def _found(source: Annotator | str) -> Annotator:
    if not isinstance(source, (str, Annotator)):
        raise AnnotatorError(f"{source!r} is no annotator: give a name, or what annotators.get(name) returns.")
    return get(source) if isinstance(source, str) else source
