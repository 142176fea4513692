"""Other renderers to compare with; all are optional, and rows say which are missing."""

from __future__ import annotations

import importlib.util

NO_PEER = "no peer"
# Packages by Python module.
PACKAGES = {"embreex": "embreex", "mitsuba": "mitsuba", "bpy": "bpy", "newton": "newton"}


def installed(module: str) -> bool:
    """Return whether a peer is installed; print what to install if not."""
    if importlib.util.find_spec(module) is None:
        print(f"{NO_PEER} {module}: pip install {PACKAGES[module]}")
        return False
    return True
