"""Helpers that scripts call beside the families. Mirrors `rep.utils`.

Nodes are usdsdg's own objects; what concerns OmniGraph as such has the nearest meaning that there is without it.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from usdsdg import files, modify
from usdsdg.errors import AssetNotFound, BadPrim, GraphError, Unsupported, warn_once
from usdsdg.graph import evaluate
from usdsdg.graph.evaluate import graph
from usdsdg.graph.kinds import action_of
from usdsdg.graph.node import Node, ReplicatorItem, plain, prim_paths
from usdsdg.registry import near_misses
from usdsdg.stage import assets, transforms
from usdsdg.stage.context import current_stage
from usdsdg.stage.node_prims import PIPELINE, TYPE_PREFIX, define_graph

__all__ = [
    "ReplicatorItem", "ReplicatorWrapper", "auto_connect", "compute_aabb", "create_node", "find_prims",
    "get_files_group", "get_graph", "get_node_targets", "get_non_xform_prims", "get_prim_variant_values",
    "get_prims_from_paths", "get_replicator_graph_exists", "get_usd_files", "read_prim_transform", "send_og_event",
    "sequential", "set_target_prims",
]  # fmt: skip


def send_og_event(event_name: str) -> None:
    """Fire `trigger.on_custom_event(event_name)` at the next app update or step, whichever comes first."""
    known = sorted({trigger.name for trigger in graph().triggers if trigger.kind == "OnCustomEvent"})
    if event_name not in known:
        near = near_misses(event_name, known)
        hint = f"did you mean {near[0]!r}?" if near else f"known events: {', '.join(known) or 'none'}."
        warn_once(f"send_og_event: nothing waits for event {event_name!r}; {hint}")
    graph().send(event_name)


# --- prims ---


def get_prims_from_paths(paths: Sequence[Any]) -> list[Usd.Prim]:
    """The prims at some paths.

    Raises:
        BadPrim: one of them is not on the stage.
    """
    return [modify.prim_at(path) for path in prim_paths(paths)]


def get_non_xform_prims(prim_paths: Any) -> list[str]:
    """Paths of the prims that carry geometry, light or lens: of a Replicator object its children, else the prim."""
    return [str(each.GetPath()) for prim in get_prims_from_paths(prim_paths) for each in modify.non_xform_prims(prim)]


_MODES: dict[str, Callable[[Usd.Prim], bool]] = {
    "instances": Usd.Prim.IsInstance,
    "materials": lambda prim: prim.IsA(UsdShade.Material),
    "meshes": lambda prim: prim.IsA(UsdGeom.Mesh),
    "prims": lambda prim: True,
}


def find_prims(prim_paths: Any, mode: str = "instances") -> list[str]:
    """Paths of what lies at and below some prims: `instances`, `prototypes` of these, `meshes`, `materials` or `prims`.

    Raises:
        GraphError: another mode.
        BadPrim: a path is not on the stage.
    """
    if mode not in _MODES and mode != "prototypes":
        raise GraphError(f"utils.find_prims: mode={mode!r}; known: {', '.join(_MODES)}, prototypes")
    below = [prim for root in get_prims_from_paths(prim_paths) for prim in Usd.PrimRange(root)]
    if mode == "prototypes":
        return list(dict.fromkeys(str(prim.GetPrototype().GetPath()) for prim in below if prim.IsInstance()))
    return [str(prim.GetPath()) for prim in below if _MODES[mode](prim)]


def get_prim_variant_values(prim_path: Any, variant_name: str) -> list[str]:
    """The variants of a prim's variant set.

    Raises:
        BadPrim: there is no such prim, or it has no such variant set.
    """
    (prim,) = get_prims_from_paths([prim_path])
    sets = prim.GetVariantSets()
    if variant_name not in sets.GetNames():
        known = ", ".join(sets.GetNames()) or "none"
        raise BadPrim(f"{prim.GetPath()} has no variant set {variant_name!r}; it has: {known}")
    return list(sets.GetVariantSet(variant_name).GetVariantNames())


def compute_aabb(bbox_cache: UsdGeom.BBoxCache, prim: Any, include_children: bool = True) -> np.ndarray:
    """(6,) lowest and highest corner of the prim's box along the world's axes [stage units].

    Without children it is the box of the prim's own extent. A prim without extent gives infinite corners, lowest above
    highest.
    """
    (prim,) = get_prims_from_paths([prim])
    if include_children:
        box = bbox_cache.ComputeWorldBound(prim).ComputeAlignedRange()
    else:
        extent = UsdGeom.Boundable(prim).GetExtentAttr().Get() if prim.IsA(UsdGeom.Boundable) else None
        local = Gf.Range3d(*(Gf.Vec3d(corner) for corner in extent)) if extent else Gf.Range3d()
        box = Gf.BBox3d(local, transforms.local_to_world(prim)).ComputeAlignedRange()
    if box.IsEmpty():
        return np.array([np.inf] * 3 + [-np.inf] * 3)
    return np.array([*box.GetMin(), *box.GetMax()])


def read_prim_transform(prim: Any) -> Gf.Matrix4d:
    """Matrix from the prim's own space to the world, row vectors [stage units]."""
    return transforms.local_to_world(get_prims_from_paths([prim])[0])


# --- files ---


def get_usd_files(path: str, recursive: bool = False, path_filter: str | None = None) -> list[str]:
    """Paths of the USD files in a folder, sorted; `path_filter` is a regular expression that is searched in each.

    Raises:
        AssetNotFound: there is no such folder.
        GraphError: `path_filter` is no regular expression.
    """
    return files.usd_files(path, recursive=recursive, path_filter=path_filter)


def get_files_group(
    folder_path: str, file_suffixes: Sequence[str] | None = None, ignore_case: bool = True, file_type: str = "png"
) -> list[dict[str, str]]:
    """Files of a folder that belong together, as textures do: `rust_diffuse.png`, `rust_normal.png`.

    Args:
        file_suffixes: ends of the names before the extension; by default diffuse, normal, roughness, metallic.
        file_type: the extension.

    Returns:
        one mapping of suffix to path for each beginning, sorted by it. Groups without all suffixes have fewer keys.

    Raises:
        AssetNotFound: there is no such folder.
    """
    root = Path(assets.resolve(folder_path))
    if not root.is_dir():
        raise AssetNotFound(f"{folder_path} is a file, not a folder")
    suffixes = list(file_suffixes or ("diffuse", "normal", "roughness", "metallic"))
    groups: dict[str, dict[str, str]] = {}
    for path in sorted(root.iterdir()):
        if path.suffix.lower() != f".{file_type.lower().lstrip('.')}":
            continue
        for suffix in suffixes:
            stem, wanted = (path.stem.lower(), suffix.lower()) if ignore_case else (path.stem, suffix)
            if stem.endswith(wanted):
                groups.setdefault(stem.removesuffix(wanted), {})[suffix] = str(path)
    return [groups[stem] for stem in sorted(groups)]


# --- the graph ---


def get_replicator_graph_exists() -> bool:
    """Whether the stage has a randomization graph."""
    return bool(current_stage().GetPrimAtPath(PIPELINE))


def get_graph(graph_path: str | None = None, is_hidden: bool = False) -> Usd.Prim:
    """The prim of the randomization graph, made where there is none.

    Raises:
        Unsupported: another path: there is one graph per stage.
    """
    if graph_path not in (None, PIPELINE):
        raise Unsupported(f"utils.get_graph: there is one graph per stage, {PIPELINE}; leave graph_path out")
    return define_graph(current_stage())


def create_node(
    node_type_id: str, graph: Any = None, node_name: str | None = None, input_prims: Any = None, **attributes: Any
) -> Node:
    """Add a node of one of our types (`omni.replicator.core.OgnWritePose`) under the current trigger.

    Raises:
        Unsupported: a type that is not ours; register a Python function with rep.randomizer.register instead.
    """
    kind = node_type_id.removeprefix(TYPE_PREFIX)
    if action_of(kind) is None:
        raise Unsupported(
            f"utils.create_node: there is no node type {node_type_id!r} here; compose rep functions and register them "
            "with rep.randomizer.register"
        )
    given = {name.removeprefix("inputs:"): plain(value) for name, value in attributes.items()}
    return evaluate.graph().add(Node(kind=kind, inputs=given, prims=prim_paths(input_prims), name=node_name))


def _node(node: Any) -> Node:
    return node.node if isinstance(node, ReplicatorItem) else node


def get_node_targets(node: Any, attribute: str) -> list[str]:
    """The prims that a node acts on (`inputs:prims`), or those of another of its inputs."""
    node = _node(node)
    if attribute.removeprefix("inputs:") == "prims":
        return list(node.prims)
    value = node.get_attribute(attribute)
    return list(prim_paths(value)) if value is not None else []


def set_target_prims(node: Any, attribute: str, target_prims: Any) -> None:
    """Let a node act on other prims (`inputs:prims`), or give another of its inputs prims, from the next execution on.

    Raises:
        BadPrim: a target is not on the stage.
    """
    node, targets = _node(node), prim_paths(target_prims)
    get_prims_from_paths(targets)
    name = attribute.removeprefix("inputs:")
    if name != "prims":
        ReplicatorItem(node).set_input(name, list(targets))
        return
    node.prims = targets
    if prim := node.path and current_stage().GetPrimAtPath(node.path):
        relation = prim.CreateRelationship("inputs:prims", custom=False)
        relation.SetTargets([Sdf.Path(path) for path in targets])


def auto_connect(first: Any, second: Any) -> None:
    """Nothing to do: nodes run in the order of the script.

    Raises:
        Unsupported: `second` was made before `first`.
    """
    order = [node for trigger in graph().triggers for node in trigger.nodes] + graph().impulses
    one, other = _node(first), _node(second)
    if one in order and other in order and order.index(other) < order.index(one):
        raise Unsupported(
            f"utils.auto_connect: {other.describe()} was made before {one.describe()}, and nodes run in the order of "
            "the script; make them in the other order"
        )


def _disconnect(first: Any, second: Any) -> None:
    """Unsupported: nodes run in the order of the script, whether they are connected or not."""
    raise Unsupported("utils._disconnect: nodes run in the order of the script; leave out the one that should not run")


@contextmanager
def sequential() -> Iterator[None]:
    """Nodes made inside run one after the other, as they always do here."""
    yield


def ReplicatorWrapper(function: Callable[..., Any]) -> Callable[..., ReplicatorItem]:
    """A function that returns a node, as one that returns an item (decorator)."""

    @functools.wraps(function)
    def wrapped(*args: Any, **kwargs: Any) -> ReplicatorItem:
        made = function(*args, **kwargs)
        return ReplicatorItem(made) if isinstance(made, Node) else made

    return wrapped
