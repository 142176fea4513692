"""Other renderers to compare with. All are optional: without one its rows say so."""

from __future__ import annotations

import importlib
import importlib.util
from types import ModuleType

NO_PEER = "no peer"
# Python module -> the package that brings it.
PACKAGES = {"embreex": "embreex", "mitsuba": "mitsuba", "bpy": "bpy", "newton": "newton"}


def find(module: str) -> ModuleType | None:
    """The peer's module; None, and a line that says what to install, where it is missing."""
    if importlib.util.find_spec(module) is None:
        print(f"{NO_PEER} {module}: pip install {PACKAGES[module]}")
        return None
    return importlib.import_module(module)
