"""What IPython shows of the classes of pxr, which have no `_repr_html_` of their own."""

from __future__ import annotations

import sys
from typing import Any

_SHOWN = {"Stage": "stage_html", "Prim": "prim_html"}  # by class of pxr.Usd: a function of `stages`


def register() -> None:
    """Let the IPython that runs, if one does, show stages and prims as trees; what the user has chosen stays."""
    ipython = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    if ipython is None:
        return
    formatter = ipython.display_formatter.formatters["text/html"]
    for name, function in _SHOWN.items():
        # By name: pxr need not be loaded for it.
        if f"pxr.Usd.{name}" not in formatter:
            formatter.for_type_by_name("pxr.Usd", name, _late(function))


def _late(function: str) -> Any:
    """Return a function of `stages` that is imported when it is called."""

    def shown(thing: Any) -> str:
        from usdsdg.notebook import stages

        return getattr(stages, function)(thing)

    return shown
