"""Annotators and augmentations by name: what `rep.annotators` and `rep.AnnotatorRegistry` offer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from usdsdg.annotators.annotator import Annotator
from usdsdg.annotators.augmentation import Augmentation, augmentations, named_augmentation
from usdsdg.annotators.base import Annotation, Kind, define, kinds
from usdsdg.annotators.frame import Frame
from usdsdg.errors import AnnotatorRegistryError, Unsupported
from usdsdg.registry import Registry

# Known names without an implementation, and why; asking for one says so instead of "unknown".
UNSUPPORTED: dict[str, str] = {}


def _unsupported(reason: str, names: str) -> None:
    UNSUPPORTED.update(dict.fromkeys(names.split(), reason))


_unsupported(
    "the depth-sensor model is not implemented; distance_to_image_plane gives exact depth",
    "DepthSensorDistance DepthSensorPointCloudPosition DepthSensorPointCloudColor DepthSensorImager",
)
_unsupported(
    "lidar and radar are out of scope",
    "RtxSensorCpu RtxSensorGpu GenericModelOutput RtxSensorMetadata StableIdMap",
)
_unsupported(
    "the renderer does not separate this part of the light",
    "Roughness SpecularAlbedo AmbientOcclusion DirectDiffuse DirectSpecular IndirectDiffuse BumpNormal Motion2d "
    "Reflections EmissionAndForegroundMask PtDirectIllumation PtGlobalIllumination PtReflections PtRefractions "
    "PtSelfIllumination PtBackground PtVolumes PtDiffuseFilter PtReflectionFilter PtRefractionFilter",
)
_unsupported(
    "it is not implemented yet",
    "shaded_semantic_segmentation shaded_instance_segmentation shaded_instance_id_segmentation "
    "cross_correspondence CrossCorrespondence Attribute primPaths fabricTime rpFabricTime",
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
    if name in UNSUPPORTED and name not in kinds:
        raise Unsupported(f"Annotator {name!r}: {UNSUPPORTED[name]}.")
    return Annotator(kinds.get(name), init_params=init_params, device=device, do_array_copy=do_array_copy)


def get_registered_annotators() -> list[str]:
    return [*kinds.names(), *_composed.names()]


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
    (_composed if name in _composed else kinds).remove(name)


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
        on_attach_callback: Any = None,
        name: str | None = None,
        is_gpu_enabled: bool = True,
        documentation: str | None = None,
    ) -> None:
        """An annotator that gives a renderer's AOV as it is."""

        def whole(frame: Frame, params: Mapping[str, Any]) -> Annotation:
            return Annotation(frame.aov(aov))

        picture = aov in ("LdrColor", "HdrColor")
        define(name or aov, aovs=() if picture else [aov], needs_picture=picture, dtype=output_data_type or np.float32)(
            whole
        )

    @staticmethod
    def register_annotator_from_node(name: str, input_rendervars: Any, node_type_id: str, **kwargs: Any) -> None:
        """Unsupported: there are no OmniGraph nodes."""
        raise Unsupported(
            f"Annotator {name!r} from node {node_type_id!r}: there is no OmniGraph here. Write a function of a "
            "Frame and register it with usdsdg.annotators.define."
        )

    @staticmethod
    def detach(annotator: Annotator, render_products: Any = None) -> None:
        annotator.detach(render_products)


__all__ = [
    "UNSUPPORTED",
    "AnnotatorRegistry",
    "Kind",
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
