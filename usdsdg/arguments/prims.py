"""Conversion of prim arguments (a path, a prim, an item, or a list of these) to prims of the current stage.

`graph.node.prim_paths` only gives the paths and does not access the stage.
"""

from collections.abc import Sequence
from typing import Any

from pxr import Sdf, Usd

from usdsdg.arguments.values import shown
from usdsdg.errors import ArgumentError, BadPrim, NotAPrim
from usdsdg.graph.node import Node, ReplicatorItem, item_of
from usdsdg.session.stage_context import current_stage
from usdsdg.stage import paths


def prim_at(path: str | Sdf.Path) -> Usd.Prim:
    """Return the prim at `path` of the current stage.

    Raises:
        BadPrim: there is none; the message lists similar paths.
    """
    return paths.prim_at(current_stage(), path)


def prims_of(prims: Any) -> list[Usd.Prim]:
    """Return the prims that a prim, a path, an item, its node or a sequence of these denotes, in order.

    Raises:
        BadPrim: a path is not on the stage, or a prim does not exist any more.
        NotAPrim: (a BadPrim and a TypeError) something else was given.
    """
    if isinstance(prims, Usd.Prim):
        prims = [prims]
    if isinstance(prims, (list, tuple)) and all(type(prim) is Usd.Prim for prim in prims):
        if not all(prims):
            expired = next(prim for prim in prims if not prim)
            raise BadPrim(f"{expired} does not exist any more; it was removed after the script looked it up")
        return list(prims)
    prims = item_of(prims)
    if isinstance(prims, ReplicatorItem):
        return [prim_at(path) for path in prims.prims]
    if isinstance(prims, (str, Sdf.Path)):
        return [prim_at(prims)]
    if isinstance(prims, Sequence):
        return [prim for each in prims for prim in prims_of(each)]
    raise NotAPrim(f"expected a prim, a path or a list of these, got {type(prims).__name__}: {shown(prims)}")


def one_prim(name: str, value: Any) -> Usd.Prim:
    """Return the single prim that the argument `name` denotes.

    Raises:
        ArgumentError: there are several, or none.
    """
    found = prims_of(value)
    if len(found) != 1:
        raise ArgumentError(f"{name} is {shown(value)}; expected one prim")
    return found[0]


def is_prim(value: Any) -> bool:
    """Whether a value is a prim, a path or an item, rather than a list of these."""
    return isinstance(value, (str, Sdf.Path, Usd.Prim, ReplicatorItem, Node))
