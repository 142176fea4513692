"""Transforms that a prim has and that do not count, since its xformOpOrder does not name them, or the reverse."""

from typing import Any

from pxr import Usd, Vt

from usdsdg.errors import warn_once

_INVERSE = "!invert!"


def warn_of_lost_ops(prim: Usd.Prim) -> None:
    """Warn where xformOpOrder names ops that the prim lacks, or where it is missing while there are ops.

    An empty xformOpOrder is one: it is how scripts clear transforms.
    """
    attribute = prim.GetAttribute("xformOpOrder")
    order: Any = attribute.Get() if attribute else None
    if isinstance(order, Vt.TokenArray) and len(order):  # files may declare another type
        # Other names are left to `transforms.local_matrix`: with one of them USD rejects xformOpOrder as a whole.
        named = [op for op in order if op.removeprefix(_INVERSE).startswith("xformOp:")]
        lost = [op for op in named if not prim.HasAttribute(op.removeprefix(_INVERSE))]
        if lost:
            warn_once(
                f"{prim.GetPath()}: its xformOpOrder names {', '.join(lost)}, which it does not have, so that is left "
                "out. Author the op, or correct xformOpOrder."
            )
    elif order is None and (ops := prim.GetAuthoredPropertiesInNamespace("xformOp")):
        names = ", ".join(op.GetName() for op in ops)
        warn_once(f"{prim.GetPath()}: it has {names} and no xformOpOrder, so it is not moved. Author xformOpOrder.")
