"""Utilities for scripts: `rep.utils`."""

from usdsdg.arguments.parameters import name_parameters
from usdsdg.graph.node import ReplicatorItem
from usdsdg.session.stage_context import open_stage
from usdsdg.stage.scopes import PIPELINE as GRAPH_PATH
from usdsdg.stage.scopes import REPLICATOR
from usdsdg.utils import viewport_manager as viewport_manager
from usdsdg.utils.files import get_files_group, get_usd_files
from usdsdg.utils.nodes import (
    ReplicatorWrapper,
    auto_connect,
    create_node,
    get_graph,
    get_node_targets,
    get_reduced_ref_time,
    get_replicator_graph_exists,
    send_og_event,
    sequential,
    set_target_prims,
)
from usdsdg.utils.prims import (
    _set_semantics_legacy as _set_semantics_legacy,
)
from usdsdg.utils.prims import (
    compute_aabb,
    create_material,
    find_prims,
    get_non_xform_prims,
    get_prim_variant_values,
    get_prims_from_paths,
    is_camera_prim,
    legacy_semantics_arg_to_new,
    parse_semantics,
    read_prim_transform,
)
from usdsdg.utils.rotation_ops import look_at, select_rotation_op, set_rotation_by_op

# Parent of the prims that scripts create, and of the graph.
REPLICATOR_SCOPE = REPLICATOR

__all__ = [
    "GRAPH_PATH",
    "REPLICATOR_SCOPE",
    "ReplicatorItem",
    "ReplicatorWrapper",
    "auto_connect",
    "compute_aabb",
    "create_material",
    "create_node",
    "find_prims",
    "get_files_group",
    "get_graph",
    "get_node_targets",
    "get_non_xform_prims",
    "get_prim_variant_values",
    "get_prims_from_paths",
    "get_reduced_ref_time",
    "get_replicator_graph_exists",
    "get_usd_files",
    "is_camera_prim",
    "legacy_semantics_arg_to_new",
    "look_at",
    "open_stage",
    "parse_semantics",
    "read_prim_transform",
    "select_rotation_op",
    "send_og_event",
    "sequential",
    "set_rotation_by_op",
    "set_target_prims",
]  # fmt: skip

name_parameters(globals())
