# The public names of usdsdg and where they are defined: read by `__init__.py` at run time, and by editors and pyright.

from . import (
    annotators,
    annotators_default,
    augmentations_default,
    backends,
    create,
    distribution,
    errors,
    example,
    functional,
    get,
    modify,
    orchestrator,
    physics,
    randomizer,
    rng,
    settings,
    tools,
    trigger,
    utils,
    writers,
    writers_default,
)
from .annotators import AnnotatorRegistry, Augmentation, NodeConnectionTemplate
from .app.new_layer import new_layer
from .augmentations_default import (
    aug_adjust_sigmoid,
    aug_brightness,
    aug_glass_blur,
    aug_hsv_to_rgb,
    aug_rgb_to_hsv,
    aug_shot_noise,
    aug_speckle_noise,
)
from .backends import BackendDispatch
from .create import mesh_decal as create_mesh_decal
from .graph.evaluate import graph as get_graph
from .graph.sampling import get_global_seed, set_global_seed
from .notebook.dataset import open_dataset
from .notebook.preview import preview
from .orchestrator import run_until_complete_async
from .session.stage_context import current_stage as get_stage
from .session.stage_context import new_stage, open_stage, save_stage
from .tools import random_colours
from .utils import viewport_manager as vp_manager
from .writers import (
    BasicWriter,
    CocoWriter,
    CosmosWriter,
    FPSWriter,
    KittiWriter,
    PoseWriter,
    Writer,
    WriterRegistry,
    WriterRegistryError,
)

__version__: str

__all__ = [
    # what a scene is made of and what changes in it
    "create", "get", "modify", "randomizer", "physics", "distribution", "trigger", "functional", "rng",
    "create_mesh_decal",
    # what comes out
    "annotators", "AnnotatorRegistry", "NodeConnectionTemplate", "annotators_default", "augmentations_default",
    "Augmentation", "aug_adjust_sigmoid", "aug_brightness", "aug_glass_blur", "aug_hsv_to_rgb", "aug_rgb_to_hsv",
    "aug_shot_noise", "aug_speckle_noise",
    "writers", "Writer", "WriterRegistry", "WriterRegistryError", "BasicWriter", "PoseWriter",
    "CocoWriter", "KittiWriter", "CosmosWriter", "FPSWriter", "writers_default",
    "backends", "BackendDispatch",
    # the stage and its graph, and a look at them
    "get_stage", "new_stage", "open_stage", "save_stage", "get_graph", "preview", "open_dataset",
    # what runs it
    "orchestrator", "settings", "utils", "get_global_seed", "set_global_seed", "new_layer",
    "run_until_complete_async", "errors", "example", "tools", "random_colours", "vp_manager",
]  # fmt: skip
