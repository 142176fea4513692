"""Target prims of nodes."""

from pxr import Usd

from usdsdg.arguments.prims import prim_at
from usdsdg.graph.node import Node


def target_prims(node: Node) -> list[Usd.Prim]:
    """Return the target prims of a node; they are looked up again if one has expired.

    Raises:
        BadPrim: one is not on the stage.
    """
    prims = node.state.get("prims")
    if prims is None or not all(prims):
        prims = node.state["prims"] = [prim_at(path) for path in node.prims]
    return prims


def non_xform_prims(prim: Usd.Prim) -> list[Usd.Prim]:
    """Return the prims with an object's own attributes: the children of an object Xform, else the prim itself."""
    if prim.GetTypeName() != "Xform" or not prim.HasAttribute("replicatorXform"):
        return [prim]
    return [child for child in prim.GetChildren() if child.GetTypeName() != "Scope"]
