"""Groups and empty transforms: `rep.create.group` and `xform`."""

from typing import Any

from usdsdg import modify
from usdsdg.arguments.prims import prim_at
from usdsdg.create.objects import create_objects
from usdsdg.graph.node import Node, ReplicatorItem, prim_paths


def group(items: Any, semantics: Any = None, name: str | None = None) -> ReplicatorItem:
    """Group prims, in the order given, so that they can be randomized together.

    Args:
        items: items, paths, prims, or a list of these.
        semantics: labels of all, or a list with those of each.
        name: of the node; writers report it.

    Raises:
        BadPrim: (a ValueError) a value is not an item, path or prim, or a path is not on the stage.
    """
    targets = prim_paths(items)
    for path in targets:
        prim_at(path)
    item = ReplicatorItem(Node(kind="OgnGroup", prims=targets, name=name))
    if semantics is not None:
        modify.semantics(semantics, input_prims=item)
    return item


def xform(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    semantics: Any = None, visible: Any = True, count: int = 1, name: str | None = None, parent: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Create `count` empty transforms `<parent>/<name>[_NN]`, by default `/Replicator/Xform`.

    Args:
        position: in the space of `parent` [stage units]; `scale` are factors and `rotation` angles [degrees].
        look_at: a point of the world [stage units] or prims, which -Z points to.
        semantics: labels of all, or a list with those of each.

    Raises:
        ArgumentError: a value has another shape, or `count` is not an integer. BadPrim: `parent` is not on the stage.
    """
    return create_objects(
        "Xform", None, position=position, scale=scale, rotation=rotation, look_at=look_at,
        look_at_up_axis=look_at_up_axis, semantics=semantics, visible=visible, node="OgnCreateXform", name=name,
        parent=parent, count=count,
    )  # fmt: skip
