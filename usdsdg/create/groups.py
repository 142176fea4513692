"""Groups and empty transforms. Mirrors `rep.create.group` and `xform`."""

from __future__ import annotations

from typing import Any

from usdsdg import modify
from usdsdg.create.objects import new_object, posed
from usdsdg.errors import BadPrim
from usdsdg.graph.node import Node, ReplicatorItem, prim_paths
from usdsdg.stage.context import current_stage
from usdsdg.values import count_of


def group(items: Any, semantics: Any = None, name: str | None = None) -> ReplicatorItem:
    """Prims to be randomized together, in the order given.

    Raises:
        BadPrim: a path is not on the stage.
    """
    targets = prim_paths(items)
    stage = current_stage()
    missing = [path for path in targets if not stage.GetPrimAtPath(path)]
    if missing:
        raise BadPrim(f"create.group: not on the stage: {', '.join(missing[:5])}")
    item = ReplicatorItem(Node(kind="OgnGroup", prims=targets, name=name))
    if semantics is not None:
        modify.semantics(semantics, input_prims=item)
    return item


def xform(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    semantics: Any = None, visible: Any = True, count: int = 1, name: str | None = None, parent: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """`count` empty transforms."""
    objects = [new_object("Xform", name, parent)[0] for _ in range(count_of(count))]
    return posed(
        objects, position=position, scale=scale, rotation=rotation, look_at=look_at, look_at_up_axis=look_at_up_axis,
        semantics=semantics, visible=visible, kind="OgnCreateXform", name=name,
    )  # fmt: skip
