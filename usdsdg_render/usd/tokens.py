"""Attributes whose value is one of a few words."""

from pxr import Usd

from usdsdg import errors


def token(prim: Usd.Prim, name: str, time: Usd.TimeCode, known: tuple[str, ...]) -> str:
    """Return the value of a token attribute; the first of `known` where none is authored.

    The first stands for an unknown word too, with a warning: USD takes any.
    """
    value = str(prim.GetAttribute(name).Get(time) or known[0])
    if value in known:
        return value
    errors.warn_once(
        f"{prim.GetPath()}: {name} {value!r} is none of {', '.join(known)}; {known[0]} is used. Correct it."
    )
    return known[0]
