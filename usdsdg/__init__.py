"""usdsdg: synthetic data from USD scenes, with the Replicator API.

`import usdsdg as rep` gives what `import omni.replicator.core as rep` gives in Omniverse.
"""

from usdsdg import (
    annotators,
    annotators_default,
    augmentations_default,
    backends,
    create,
    distribution,
    functional,
    get,
    modify,
    orchestrator,
    physics,
    randomizer,
    rng,
    settings,
    trigger,
    utils,
    writers,
    writers_default,
)  # fmt: skip
from usdsdg.annotators import AnnotatorRegistry, NodeConnectionTemplate
from usdsdg.app.new_layer import new_layer
from usdsdg.backends import BackendDispatch
from usdsdg.create import mesh_decal as create_mesh_decal
from usdsdg.graph.sampling import get_global_seed, set_global_seed
from usdsdg.session.stage_context import open_stage
from usdsdg.writers import (
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

__version__ = "0.1.0"

__all__ = [
    # what a scene is made of and what changes in it
    "create", "get", "modify", "randomizer", "physics", "distribution", "trigger", "functional", "rng",
    "create_mesh_decal",
    # what comes out
    "annotators", "AnnotatorRegistry", "NodeConnectionTemplate", "annotators_default", "augmentations_default",
    "writers", "Writer", "WriterRegistry", "WriterRegistryError", "BasicWriter", "PoseWriter",
    "CocoWriter", "KittiWriter", "CosmosWriter", "FPSWriter", "writers_default",
    "backends", "BackendDispatch",
    # what runs it
    "orchestrator", "settings", "utils", "get_global_seed", "set_global_seed", "open_stage", "new_layer",
]  # fmt: skip
