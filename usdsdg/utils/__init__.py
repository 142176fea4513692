"""Utilities for scripts: `rep.utils`."""

from usdsdg.arguments.parameters import name_parameters
from usdsdg.graph.node import ReplicatorItem
from usdsdg.utils.files import get_files_group, get_usd_files
from usdsdg.utils.nodes import (
    ReplicatorWrapper,
    auto_connect,
    create_node,
    get_graph,
    get_node_targets,
    get_replicator_graph_exists,
    send_og_event,
    sequential,
    set_target_prims,
)
from usdsdg.utils.prims import (
    compute_aabb,
    find_prims,
    get_non_xform_prims,
    get_prim_variant_values,
    get_prims_from_paths,
    legacy_semantics_arg_to_new,
    parse_semantics,
    read_prim_transform,
)

__all__ = [
    "ReplicatorItem", "ReplicatorWrapper", "auto_connect", "compute_aabb", "create_node", "find_prims",
    "get_files_group", "get_graph", "get_node_targets", "get_non_xform_prims", "get_prim_variant_values",
    "get_prims_from_paths", "get_replicator_graph_exists", "get_usd_files",
    "legacy_semantics_arg_to_new", "parse_semantics", "read_prim_transform", "send_og_event",
    "sequential", "set_target_prims",
]  # fmt: skip

name_parameters(globals())
