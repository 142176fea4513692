"""The script that Python runs, as it was when it imported usdsdg."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from usdsdg.writers.journal.recipe import Source


def main_script() -> Path | None:
    """Return the script that Python runs; None in notebooks, in tests, and for installed programs."""
    main = getattr(sys.modules.get("__main__"), "__file__", None)
    if not main or not main.endswith(".py") or not os.path.isfile(main):
        return None
    script = Path(main).resolve()
    if any(script.is_relative_to(Path(each).resolve()) for each in (sys.prefix, sys.base_prefix)):
        return None
    return None if script.name == "__main__.py" else script  # that of `python -m` of a package


def started_source(script: Path) -> Source:
    """Return what the script had in it when it imported usdsdg, which its file may have no more at the first writer."""
    known = sys.modules["usdsdg"]._MAIN_SOURCE
    is_same = known is not None and Path(known[0]).resolve() == script
    return Source(script, known[1]) if known is not None and is_same else Source.read(script)
