"""What USD's own errors mean to a script, which name neither a prim nor a remedy."""

from __future__ import annotations

import re
import traceback
from collections.abc import Iterator

_NO_PRIM = (
    "There was no prim where the script looked for it: USD returns an invalid prim for such a path, which fails at its "
    "first use. Test it with `if prim:`, or print(stage.GetPrimAtPath(...)) to see which path is wrong."
)
_REMOVED = (
    "The prim {path} was removed, or its stage was replaced by new_stage() or open_stage(), after the script had "
    "looked it up. Look it up again, on the stage that omni.usd.get_context().get_stage() returns."
)
_STAGE = (
    "The stage in `{name}` has been closed: new_stage() or open_stage() replaced it after the script had taken it. "
    "Take it again: {name} = omni.usd.get_context().get_stage()."
)


def remedy(error: BaseException) -> str | None:
    """Return what to say beside an error that USD has raised; None for others."""
    said = str(error)
    if isinstance(error, RuntimeError) and said.startswith("Accessed invalid null prim"):
        return _NO_PRIM
    if isinstance(error, RuntimeError) and (found := re.match(r"Accessed invalid expired .*?prim <(.*?)>", said)):
        return _REMOVED.format(path=found[1])
    if type(error).__module__ == "Boost.Python" and (name := next(_closed_stages(error), None)):
        return _STAGE.format(name=name)
    return None


def _closed_stages(error: BaseException) -> Iterator[str]:
    """Go over the names of closed stages where the error was raised: variables of the function, then of its module."""
    from pxr import Usd

    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    for variables in (frames[-1].f_locals, frames[-1].f_globals) if frames else ():
        for name, value in list(variables.items()):
            if isinstance(value, Usd.Stage) and value.expired:
                yield name
