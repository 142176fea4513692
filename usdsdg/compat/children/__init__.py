"""What makes foreign names importable in the processes that a script starts: `sitecustomize`, beside this.

`usdsdg run` puts this folder on PYTHONPATH, so that every Python that the script starts runs that at its start. An
environment variable holds the options of the command, such as --assets-root, which `options` writes and reads.
"""

from __future__ import annotations

import os
from pathlib import Path

from usdsdg.compat.children import options
from usdsdg.session.script_processes import MODULES


def reach() -> None:
    """Let Pythons that are started from here on import the foreign names, with the options of this process."""
    folder, before = str(Path(__file__).parent), os.environ.get(MODULES)
    paths = before.split(os.pathsep) if before else []
    if folder not in paths:
        os.environ[MODULES] = os.pathsep.join([folder, *paths])
    options.tell()
