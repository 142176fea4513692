"""The prims that an action works on."""

from pxr import Usd

from usdsdg.arguments.prims import prim_at
from usdsdg.graph.node import Node


def target_prims(node: Node) -> list[Usd.Prim]:
    """The targets of a node, looked up again when one of them has gone.

    Raises:
        BadPrim: one is not on the stage.
    """
    prims = node.state.get("prims")
    if prims is None or not all(prims):
        prims = node.state["prims"] = [prim_at(path) for path in node.prims]
    return prims


def non_xform_prims(prim: Usd.Prim) -> list[Usd.Prim]:
    """Where an object's attributes live: the prim itself, or the children of an object Xform."""
    if prim.GetTypeName() != "Xform" or not prim.HasAttribute("replicatorXform"):
        return [prim]
    return [child for child in prim.GetChildren() if child.GetTypeName() != "Scope"]
