"""`isaacsim.core.deprecation_manager`: modules that may be absent."""

import importlib
from types import ModuleType


def import_module(name: str) -> ModuleType:
    """Import a module, such as "torch".

    Raises:
        ModuleNotFoundError: it is not installed; Isaac Sim ends the application.
    """
    return importlib.import_module(name)
