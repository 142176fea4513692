"""Object prims: an Xform `/Replicator/<Type>_Xform[_NN]` with pose and labels, and one child `<Type>`."""

from collections.abc import Callable, Sequence
from typing import Any

from pxr import Sdf, Usd

from usdsdg import modify
from usdsdg.arguments.values import count_of
from usdsdg.graph.node import Node, ReplicatorItem, prim_paths
from usdsdg.session.stage_context import current_stage
from usdsdg.stage import paths
from usdsdg.stage.copies import copy_prim

ROOT = "/Replicator"


def new_objects(
    kind: str, name: str | None, parent: Any, count: Any, define: Callable[[Usd.Stage, str], object]
) -> tuple[list[Usd.Prim], list[Usd.Prim]]:
    """Create object Xforms with the child that `define` makes at a path of a stage; return them and the children.

    The first is copied, in one change: one by one, each would take as long as its parent has children.

    Raises:
        ArgumentError: `count` is not an integer, or negative. BadPrim: as for `new_object`.
    """
    if not (number := count_of(count)):
        return [], []
    prim, path = new_object(kind, name, parent)
    stage = prim.GetStage()
    define(stage, path)
    target, label = stage.GetEditTarget(), name or kind
    others = paths.free_paths(stage, f"{prim.GetPath().GetParentPath()}/{label}_Xform", number - 1)
    copies = copy_prim(stage, target.GetLayer(), target.MapToSpecPath(prim.GetPath()), others)
    objects = [prim, *copies]
    return objects, [each.GetChild(label) for each in objects]


def new_object(kind: str, name: str | None, parent: Any) -> tuple[Usd.Prim, str]:
    """Create an object Xform; return it and the path for its child.

    Raises:
        BadPrim: `parent` is not on the stage, or `name` cannot be the name of a prim.
    """
    label = name or kind
    prim = new_xform(f"{label}_Xform", parent)
    return prim, f"{prim.GetPath()}/{label}"


def new_xform(name: str, parent: Any) -> Usd.Prim:
    """Create the Xform `<parent>/<name>[_NN]` of an object, by default below `/Replicator`.

    Raises:
        BadPrim: `parent` is not on the stage, or `name` cannot be the name of a prim.
    """
    stage = current_stage()
    root = prim_paths(parent)[0] if parent is not None else ROOT
    if parent is None and not stage.GetPrimAtPath(ROOT):
        stage.DefinePrim(ROOT, "Scope")
    paths.prim_at(stage, root)
    prim = stage.DefinePrim(paths.next_free_path(stage, f"{root}/{name}"), "Xform")
    prim.CreateAttribute("replicatorXform", Sdf.ValueTypeNames.Bool, custom=True).Set(True)
    return prim


def apply_common_arguments(
    objects: Sequence[Usd.Prim],
    *,
    position: Any = None,
    rotation: Any = None,
    scale: Any = None,
    look_at: Any = None,
    look_at_up_axis: Any = None,
    pivot: Any = None,
    semantics: Any = None,
    visible: Any = True,
    kind: str,
    name: str | None = None,
) -> ReplicatorItem:
    """Write pose, labels and visibility of objects, or schedule them where they are distributions; return the item."""
    item = ReplicatorItem(Node(kind=kind, prims=tuple(str(prim.GetPath()) for prim in objects), name=name))
    modify.apply_or_schedule_pose(
        item, position=position, pivot=pivot, rotation=rotation, scale=scale, look_at=look_at,
        look_at_up_axis=look_at_up_axis,
    )  # fmt: skip
    if semantics is not None:
        modify.semantics(semantics, input_prims=item)
    if visible is not True:
        modify.visibility(visible, input_prims=item)
    return item
