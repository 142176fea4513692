"""Whether prims are of a type, asked once for each name of a type instead of for each prim, which takes four times."""

from __future__ import annotations

from pxr import Usd


class PrimTypes:
    """The prims of one traversal that are of any of some schemas, derived ones included."""

    def __init__(self, *schemas: type[Usd.SchemaBase]) -> None:
        self._schemas = schemas
        self._known: dict[str, bool] = {}  # by the names of types

    def have(self, prim: Usd.Prim) -> bool:
        """Return whether the prim is of one of the schemas."""
        name = prim.GetTypeName()
        known = self._known.get(name)
        if known is None:
            known = self._known[name] = any(map(prim.IsA, self._schemas))
        return known
