"""Annotators and augmentations by name: what `rep.annotators` and `rep.AnnotatorRegistry` offer."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from usdsdg.annotators.annotator import Annotator, attached_annotators
from usdsdg.annotators.aov_annotator import register_aov
from usdsdg.annotators.augmentations.augmentation import Augmentation, augmentations, named_augmentation, node_specs
from usdsdg.annotators.base import AnnotatorSpec, annotator_specs
from usdsdg.arguments.registry import Registry
from usdsdg.errors import AnnotatorRegistryError, Unsupported

# Known names without an implementation, and why; asking for one says so instead of "unknown".
UNSUPPORTED: dict[str, str] = {}


def _unsupported(reason: str, names: str) -> None:
    UNSUPPORTED.update(dict.fromkeys(names.split(), reason))


_unsupported(
    "lidar and radar are out of scope",
    "RtxSensorCpu RtxSensorGpu GenericModelOutput RtxSensorMetadata StableIdMap",
)

_composed: Registry[Annotator] = Registry("annotator", AnnotatorRegistryError)


def get(
    name: str,
    init_params: Mapping[str, Any] | None = None,
    render_product_idxs: Sequence[int] | None = None,
    device: str | None = None,
    do_array_copy: bool = True,
) -> Annotator:
    """A new, unattached annotator.

    Args:
        name: of the annotator, or of one that was registered.
        init_params: see `Annotator.initialize`.
        render_product_idxs: accepted and ignored: an annotator watches one render product.
        device: "cpu" or None for NumPy arrays, "cuda[:n]" for Warp arrays, of what `get_data` returns.
        do_array_copy: whether `get_data` gives an array of the caller's own.

    Raises:
        AnnotatorRegistryError: there is no such annotator; the message lists near misses.
        Unsupported: Replicator has it and usdsdg does not.
    """
    if name in _composed:
        found = _composed.get(name).copy(device=device)
        return found.initialize(**init_params) if init_params else found
    if name in UNSUPPORTED and name not in annotator_specs:
        raise Unsupported(f"Annotator {name!r}: {UNSUPPORTED[name]}.")
    return Annotator(annotator_specs.get(name), init_params=init_params, device=device, do_array_copy=do_array_copy)


def get_registered_annotators() -> list[str]:
    """Names of all annotators that `get` makes, those of scripts last."""
    return [*annotator_specs.names(), *_composed.names()]


def register(name: str, annotator: Annotator | str) -> None:
    """Make an (augmented) annotator, or one of another name, available under `name`; replaces an earlier one.

    Raises:
        AnnotatorRegistryError: it is no annotator, and no name of one.
    """
    if isinstance(annotator, str):
        annotator = get(annotator)
    if not isinstance(annotator, Annotator):
        raise AnnotatorRegistryError(f"register({name!r}, ...): {annotator!r} is not an Annotator.")
    _composed.add(name, annotator.copy(name))


def unregister_annotator(name: str) -> None:
    """Forget an annotator.

    Raises:
        AnnotatorRegistryError: there is no such annotator; the message lists near misses.
    """
    (_composed if name in _composed else annotator_specs).remove(name)


def get_augmentation(name: str) -> Augmentation:
    """A registered augmentation, or one of Replicator's (`augmentation_table`).

    Raises:
        AnnotatorRegistryError: there is no such augmentation; the message lists near misses.
    """
    return augmentations.get(name)


def register_augmentation(name: str, augmentation: Any) -> None:
    """Make an augmentation (or a function, a registered name, or the type of a node) available under `name`."""
    augmentations.add(name, named_augmentation(augmentation))


def unregister_augmentation(name: str) -> None:
    """Forget an augmentation.

    Raises:
        AnnotatorRegistryError: there is no such augmentation; the message lists near misses.
    """
    augmentations.remove(name)


def augment(
    source_annotator: Annotator | str,
    augmentation: Any,
    data_out_shape: Any = None,
    name: str | None = None,
    device: Any = None,
    **kwargs: Any,
) -> Annotator:
    """A new annotator: `source_annotator` (object or name) whose array passes through `augmentation`.

    See `Annotator.augment` for the arguments and errors; the source stays as it is.
    """
    source = get(source_annotator) if isinstance(source_annotator, str) else source_annotator.copy()
    return source.augment(augmentation, data_out_shape, name, device, **kwargs)


def augment_compose(
    source_annotator: Annotator | str, augmentations: Sequence[Any], name: str | None = None
) -> Annotator:
    """A new annotator: `source_annotator` (object or name) whose array passes through several augmentations in turn.

    See `Annotator.augment_compose` for errors; the source stays as it is.
    """
    source = get(source_annotator) if isinstance(source_annotator, str) else source_annotator.copy()
    return source.augment_compose(augmentations, name)


@dataclass(frozen=True)
class NodeConnectionTemplate:
    """An input of a node, as scripts describe it: an annotator's name, and which outputs go to which inputs.

    Mirrors `omni.syntheticdata.SyntheticData.NodeConnectionTemplate`; the mapping of attributes has no meaning here.
    """

    node_template_id: str
    render_product_idxs: Sequence[int] = (0,)
    attributes_mapping: Mapping[str, str] | None = None


class AnnotatorRegistry:
    """The same functions under Replicator's older names."""

    _default_annotators: list[str] = []

    get_annotator = staticmethod(get)
    get_registered_annotators = staticmethod(get_registered_annotators)
    get_augmentation = staticmethod(get_augmentation)
    register_augmentation = staticmethod(register_augmentation)
    unregister_augmentation = staticmethod(unregister_augmentation)
    unregister_annotator = staticmethod(unregister_annotator)

    @staticmethod
    def register_annotator_from_aov(
        aov: str,
        output_data_type: Any = None,
        output_channels: int = 1,
        on_attach_callback: Callable[[Annotator], None] | None = None,
        name: str | None = None,
        is_gpu_enabled: bool = True,
        documentation: str | None = None,
    ) -> None:
        """Make what the renderer gives as `aov` available as an annotator.

        Args:
            aov: name of an annotator that is one picture ("LdrColor", "DepthLinearized"), or of an AOV of the renderer.
            output_data_type: NumPy type of the result; None: as it is.
            output_channels: how many of its channels are given, where it has several; 1: all.
            on_attach_callback: called with the annotator when it is attached.
            name: default, `aov`.
            is_gpu_enabled: accepted; `device` says where arrays are given.
            documentation: default, that of what it shows.

        Raises:
            AnnotatorRegistryError: there is no such AOV; the message lists near misses.
            Unsupported: Replicator has it and usdsdg does not.
        """
        register_aov(
            name or aov, aov, output_data_type, output_channels, on_attach_callback, documentation, UNSUPPORTED
        )

    @staticmethod
    def register_annotator_from_node(
        name: str,
        input_rendervars: Any,
        node_type_id: str,
        init_params: Mapping[str, Any] | None = None,
        render_product_idxs: Sequence[int] = (0,),
        output_rendervars: Any = None,
        output_data_type: Any = None,
        output_is_2d: bool = False,
        output_channels: int = 1,
        is_gpu_enabled: bool = True,
        hidden: bool = False,
        on_attach_callback: Any = None,
        documentation: str | None = None,
    ) -> None:
        """Make an annotator that passes through an augmentation node available, or one whose node does what ours does.

        There is no OmniGraph, so only nodes that are known here work: Replicator's augmentation nodes
        ("omni.replicator.core.AugRotateExp", on the first of `input_rendervars`) and Isaac Sim's times.

        Args:
            name: under which it is made available.
            input_rendervars: names of annotators, or templates of a connection to them.
            node_type_id: type of the node.
            init_params: arguments of the node.
            render_product_idxs, output_rendervars, output_data_type, output_is_2d, output_channels, is_gpu_enabled,
                hidden, on_attach_callback, documentation: accepted; the annotator's own hold.

        Raises:
            Unsupported: the node is another one.
            AnnotatorRegistryError: there is no annotator of the first input's name.
            AugmentationError: the node takes no such argument.
        """
        short = str(node_type_id).rsplit(".", 1)[-1].removeprefix("Ogn")
        arguments = {key.removeprefix("inputs:"): value for key, value in (init_params or {}).items()}
        if short in _NODE_ANNOTATORS:
            _composed.add(name, get(_NODE_ANNOTATORS[short], arguments).copy(name))
            return
        if short not in node_specs:
            raise Unsupported(
                f"Annotator {name!r} from node {node_type_id!r}: there is no OmniGraph here, and this node is none of "
                f"{', '.join([*_NODE_ANNOTATORS, *node_specs])}. Write a function of a Frame and register it with "
                "usdsdg.annotators.define."
            )
        source = list(input_rendervars)[:1] or [""]
        _composed.add(name, augment(_rendervar(source[0]), Augmentation(short, **arguments), name=name))

    @staticmethod
    def detach(annotator: Annotator | str, render_products: Any) -> None:
        """Detach an annotator, or all of a name, from `render_products` (None: from whatever they watch)."""
        wanted = [annotator] if isinstance(annotator, Annotator) else attached_annotators()
        for each in wanted:
            if each is annotator or each.get_name() == annotator:
                each.detach(render_products)


# Nodes that make an annotator of their own, and ours.
_NODE_ANNOTATORS = {
    "IsaacReadSimulationTimeAnnotator": "IsaacReadSimulationTime",
    "IsaacReadSimulationTime": "IsaacReadSimulationTime",
    "IsaacReadSystemTimeAnnotator": "IsaacReadSystemTime",
    "IsaacReadSystemTime": "IsaacReadSystemTime",
    "SdNoOp": "IsaacNoop",
    "ReadFabricTime": "fabricTime",
    "ReadRpFabricTime": "rpFabricTime",
}


def _rendervar(source: Any) -> str:
    """The annotator that an input of a node names: a name, or a template that has it."""
    return str(getattr(source, "node_template_id", source))


__all__ = [
    "UNSUPPORTED",
    "AnnotatorRegistry",
    "AnnotatorSpec",
    "NodeConnectionTemplate",
    "augment",
    "augment_compose",
    "get",
    "get_augmentation",
    "get_registered_annotators",
    "register",
    "register_augmentation",
    "unregister_annotator",
    "unregister_augmentation",
]
