"""What makes foreign names importable in the processes that a script starts: `sitecustomize`, beside this.

`usdsdg run` puts this folder on PYTHONPATH, so that every Python that the script starts runs that at its start.
"""

from __future__ import annotations

import os
from pathlib import Path


def reach() -> None:
    """Let Pythons that are started from here on import the foreign names."""
    folder, before = str(Path(__file__).parent), os.environ.get("PYTHONPATH")
    paths = before.split(os.pathsep) if before else []
    if folder not in paths:
        os.environ["PYTHONPATH"] = os.pathsep.join([folder, *paths])
