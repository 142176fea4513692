"""Simulate the rigid bodies of a USD stage with Newton, and write poses and velocities back to the prims.

The public names load when they are first used (PEP 562), so that one room of the package loads without the others.
"""

import importlib
from typing import Any

_PUBLIC = {
    "NewtonEngine": "engine",
    "Overlap": "queries.scene_queries",
    "RayHit": "queries.scene_queries",
    "precompile": "simulation",
    "simulate": "simulation",
}


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'usdsdg_physics' has no attribute {name!r}")
    return getattr(importlib.import_module(f"usdsdg_physics.{_PUBLIC[name]}"), name)
