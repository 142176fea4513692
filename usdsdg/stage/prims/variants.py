"""Selections of variants."""

from pxr import Usd

from usdsdg.errors import BadPrim


def select_variant(prim: Usd.Prim, name: str, variant: str) -> None:
    """Select a variant of the variant set `name` of a prim.

    Raises:
        BadPrim: it has no such variant set, or the set no such variant; lists the existing ones.
    """
    sets = prim.GetVariantSets()
    if name not in sets.GetNames():
        raise BadPrim(f"{prim.GetPath()} has no variant set {name!r}; it has {', '.join(sets.GetNames()) or 'none'}")
    known = sets.GetVariantSet(name).GetVariantNames()
    if variant not in known:
        raise BadPrim(f"{prim.GetPath()}: variant set {name!r} has no {variant!r}; it has {', '.join(known) or 'none'}")
    sets.GetVariantSet(name).SetVariantSelection(variant)
