"""Annotators: what is seen in one frame, as labelled arrays (`rep.annotators`)."""

# Members of the family register themselves when imported.
from usdsdg.annotators.annotator import Annotator, Requirements, attached_annotators, detach_all, requirements
from usdsdg.annotators.augmentations import defaults as default_augmentations
from usdsdg.annotators.augmentations.augmentation import Augmentation
from usdsdg.annotators.base import Annotation, define
from usdsdg.annotators.catalogue import (
    AnnotatorRegistry,
    NodeConnectionTemplate,
    augment,
    augment_compose,
    get,
    get_augmentation,
    get_registered_annotators,
    register,
    register_augmentation,
    unregister_annotator,
    unregister_augmentation,
)
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.kinds import (
    amodal,
    boxes,
    camera,
    correspondence,
    depth_camera,
    image,
    light,
    matte,
    pointcloud,
    segmentation,
    shading,
    skeleton,
    stage_values,
)
from usdsdg.annotators.labeled_prims import LabeledPrimReader, LabeledPrims
from usdsdg.annotators.payload import Capture, build_payload, lay_out
from usdsdg.errors import AnnotatorError, AnnotatorRegistryError, AugmentationError

__all__ = [
    "Annotation",
    "Annotator",
    "AnnotatorError",
    "AnnotatorRegistry",
    "AnnotatorRegistryError",
    "Augmentation",
    "AugmentationError",
    "Capture",
    "Frame",
    "LabeledPrimReader",
    "LabeledPrims",
    "NodeConnectionTemplate",
    "Requirements",
    "amodal",
    "attached_annotators",
    "augment",
    "augment_compose",
    "boxes",
    "build_payload",
    "camera",
    "correspondence",
    "default_augmentations",
    "define",
    "depth_camera",
    "detach_all",
    "get",
    "get_augmentation",
    "get_registered_annotators",
    "image",
    "lay_out",
    "light",
    "matte",
    "pointcloud",
    "register",
    "register_augmentation",
    "requirements",
    "segmentation",
    "shading",
    "skeleton",
    "stage_values",
    "unregister_annotator",
    "unregister_augmentation",
]
