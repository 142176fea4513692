"""Annotators and augmentations under Replicator's older names: `rep.AnnotatorRegistry`."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from usdsdg.annotators.annotator import Annotator, attached_annotators
from usdsdg.annotators.aov_annotator import register_aov
from usdsdg.annotators.augmentations.array_transform import node_specs
from usdsdg.annotators.augmentations.augmentation import (
    Augmentation,
    get_augmentation,
    register_augmentation,
    unregister_augmentation,
)
from usdsdg.annotators.named_annotators import (
    UNSUPPORTED,
    augment,
    get,
    get_registered_annotators,
    registered_annotators,
    unregister_annotator,
)
from usdsdg.errors import Unsupported


@dataclass(frozen=True)
class NodeConnectionTemplate:
    """An input of a node: the name of an annotator, and which of its outputs connect to which inputs.

    Mirrors `omni.syntheticdata.SyntheticData.NodeConnectionTemplate`; the mapping of attributes is ignored.
    """

    node_template_id: str
    render_product_idxs: Sequence[int] = (0,)
    attributes_mapping: Mapping[str, str] | None = None


class _Registered(Mapping[str, Annotator]):
    """All registered annotators by name, each made when it is asked for."""

    def __getitem__(self, name: str) -> Annotator:
        """Return a new annotator; a KeyError where none has the name."""
        if name not in get_registered_annotators():
            raise KeyError(name)
        return get(name)

    def __iter__(self) -> Iterator[str]:
        return iter(get_registered_annotators())

    def __len__(self) -> int:
        return len(get_registered_annotators())


class AnnotatorRegistry:
    """The functions of `usdsdg.annotators` under Replicator's older names."""

    _default_annotators: list[str] = []
    _annotators: Mapping[str, Annotator] = _Registered()

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
        """Register an annotator that returns the AOV `aov` of the renderer.

        Args:
            aov: name of an annotator that is one image ("LdrColor", "DepthLinearized"), or of an AOV of the renderer.
            output_data_type: NumPy type of the result; None: that of the AOV.
            output_channels: how many channels are returned of an AOV with several; 1: all.
            on_attach_callback: called with the annotator when it is attached.
            name: default, `aov`.
            is_gpu_enabled: accepted and ignored; `device` says where arrays are returned.
            documentation: default, that of the source.

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
        """Register an annotator that applies an augmentation node, or whose node has an equivalent annotator.

        There is no OmniGraph, so only these nodes work: Replicator's augmentation nodes
        ("omni.replicator.core.AugRotateExp", on the first of `input_rendervars`), Isaac Sim's times and gates, and its
        poses for DOPEWriter and YCBVideoWriter.

        Args:
            name: under which the annotator is registered.
            input_rendervars: names of annotators, or connection templates to them.
            node_type_id: type of the node.
            init_params: arguments of the node.
            render_product_idxs, output_rendervars, output_data_type, output_is_2d, output_channels, is_gpu_enabled,
                hidden, on_attach_callback, documentation: accepted and ignored; those of the annotator apply.

        Raises:
            Unsupported: any other node.
            AnnotatorRegistryError: there is no annotator of the first input's name.
            AugmentationError: the node takes no such argument.
        """
        short = str(node_type_id).rsplit(".", 1)[-1].removeprefix("Ogn")
        arguments = {key.removeprefix("inputs:"): value for key, value in (init_params or {}).items()}
        if short in _NODE_ANNOTATORS:
            registered_annotators.add(name, get(_NODE_ANNOTATORS[short], arguments).copy(name))
            return
        if short not in node_specs:
            raise Unsupported(
                f"Annotator {name!r} from node {node_type_id!r}: there is no OmniGraph here, and this node is none of "
                f"{', '.join([*_NODE_ANNOTATORS, *node_specs])}. Write a function of a Frame and register it with "
                "usdsdg.annotators.define."
            )
        source = list(input_rendervars)[:1] or [""]
        registered_annotators.add(name, augment(_rendervar(source[0]), Augmentation(short, **arguments), name=name))

    @staticmethod
    def detach(annotator: Annotator | str, render_products: Any) -> None:
        """Detach an annotator, or all of that name, from `render_products` (None: from any)."""
        wanted = [annotator] if isinstance(annotator, Annotator) else attached_annotators()
        for each in wanted:
            if each is annotator or each.get_name() == annotator:
                each.detach(render_products)


# Type of a node → the annotator with the same output.
_NODE_ANNOTATORS = {
    "IsaacReadSimulationTimeAnnotator": "IsaacReadSimulationTime",
    "IsaacReadSimulationTime": "IsaacReadSimulationTime",
    "IsaacReadSystemTimeAnnotator": "IsaacReadSystemTime",
    "IsaacReadSystemTime": "IsaacReadSystemTime",
    "SdNoOp": "IsaacNoop",
    "ReadFabricTime": "fabricTime",
    "ReadRpFabricTime": "rpFabricTime",
    "Dope": "dope",
    "Pose": "pose",
    # Order in a graph, of which there is none.
    "RationalTimeSyncGate": "IsaacNoop",
    "SyncGate": "IsaacNoop",
}


def _rendervar(source: Any) -> str:
    """Return the annotator name of a node input: the name itself, or that of its connection template."""
    return str(getattr(source, "node_template_id", source))
