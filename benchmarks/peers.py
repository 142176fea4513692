"""Other renderers to compare with. All are optional: without one its rows say so."""

from __future__ import annotations

import importlib.util

NO_PEER = "no peer"
# Python module -> the package that brings it.
PACKAGES = {"embreex": "embreex", "mitsuba": "mitsuba", "bpy": "bpy", "newton": "newton"}


def installed(module: str) -> bool:
    """Whether the peer is installed; if not, a line says what to install."""
    if importlib.util.find_spec(module) is None:
        print(f"{NO_PEER} {module}: pip install {PACKAGES[module]}")
        return False
    return True
