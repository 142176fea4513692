"""Annotators: the labels of one rendered frame, as arrays and tables (`rep.annotators`)."""

from usdsdg.annotators import kinds  # noqa: F401 - registers the annotators
from usdsdg.annotators.annotator import Annotator, attached_annotators, detach_all
from usdsdg.annotators.annotator_registry import AnnotatorRegistry, NodeConnectionTemplate
from usdsdg.annotators.augmentations import defaults  # noqa: F401 - registers the augmentations
from usdsdg.annotators.augmentations.augmentation import (
    Augmentation,
    get_augmentation,
    register_augmentation,
    unregister_augmentation,
)
from usdsdg.annotators.base import Annotation, define
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.labeled_prims import LabeledPrimReader, LabeledPrims
from usdsdg.annotators.named_annotators import (
    augment,
    augment_compose,
    get,
    get_registered_annotators,
    register,
    unregister_annotator,
)
from usdsdg.annotators.payload import Capture, build_payload, lay_out
from usdsdg.annotators.requirements import Requirements, requirements
from usdsdg.arguments.parameters import name_parameters
from usdsdg.errors import AnnotatorError, AnnotatorRegistryError, AugmentationError

__all__ = [
    # annotators by name
    "get", "get_registered_annotators", "Annotator", "AnnotatorRegistry", "NodeConnectionTemplate",
    # augmentations of their arrays
    "augment", "augment_compose", "Augmentation", "get_augmentation", "register_augmentation",
    "unregister_augmentation",
    # annotators of one's own
    "define", "Frame", "Annotation", "register", "unregister_annotator",
    # what a capture needs: what is attached, what to render, which prims are labeled, what writers receive
    "attached_annotators", "detach_all", "requirements", "Requirements",
    "LabeledPrimReader", "LabeledPrims", "Capture", "build_payload", "lay_out",
    # errors
    "AnnotatorError", "AnnotatorRegistryError", "AugmentationError",
]  # fmt: skip

name_parameters(globals())
