"""Import hook: `omni.x` is `usdsdg.compat.omni.x`, and `omni.replicator.core` is `usdsdg` itself.

Both names give one module object, so there is one registry and one stage. The hook stands first on `sys.meta_path`:
appended last, a submodule would be found through its parent's path and loaded twice. A real Omniverse install wins.
"""

from __future__ import annotations

import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import sys
from types import ModuleType

from usdsdg.errors import Unsupported

ROOTS = ("omni", "carb", "usdrt", "isaacsim")
# Longest prefix first: these are not mirrored as files, they are the product itself.
ALIASES = (
    ("omni.replicator.core.scripts", "usdsdg"),
    ("omni.replicator.core", "usdsdg"),
    ("omni.replicator.replicator_yaml", "usdsdg.replicator_yaml"),
)


def real_name(name: str) -> str:
    """The module that a foreign name stands for."""
    for prefix, target in ALIASES:
        if name == prefix or name.startswith(prefix + "."):
            return target + name[len(prefix) :]
    return f"usdsdg.compat.{name}"


class _Loader(importlib.abc.Loader):
    """Hands out the real module and leaves its own import facts as they were."""

    def __init__(self, real: str) -> None:
        self._real = real

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> ModuleType:
        module = importlib.import_module(self._real)
        self._facts = (module.__spec__, module.__loader__)
        return module

    def exec_module(self, module: ModuleType) -> None:
        module.__spec__, module.__loader__ = self._facts


class _Finder(importlib.abc.MetaPathFinder):
    def find_spec(self, name: str, path: object = None, target: object = None) -> importlib.machinery.ModuleSpec | None:
        if name.split(".", 1)[0] not in ROOTS:
            return None
        real = real_name(name)
        if _exists(real):
            return importlib.machinery.ModuleSpec(name, _Loader(real), is_package=True)
        raise ModuleNotFoundError(_missing(name), name=name)


def _exists(real: str) -> bool:
    try:
        return importlib.util.find_spec(real) is not None
    except ModuleNotFoundError:
        return False


def _missing(name: str) -> str:
    return (
        f"{name}: this module of Isaac Sim or Omniverse has no counterpart in usdsdg yet. "
        "docs/compatibility.md lists what there is; if the script needs only a small part of it, guard the import."
    )


def is_installed() -> bool:
    """Whether the foreign names are importable."""
    return any(isinstance(finder, _Finder) for finder in sys.meta_path)


def install() -> None:
    """Make the foreign names importable.

    Raises:
        Unsupported: a real Omniverse is importable here; its modules and ours must not mix.
    """
    if is_installed():
        return
    for root in ("omni.replicator", "carb"):
        try:
            found = importlib.util.find_spec(root)
        except ModuleNotFoundError:
            found = None
        if found is not None:
            raise Unsupported(
                f"{root} is already installed ({found.origin}); run the script with that Omniverse instead."
            )
    sys.meta_path.insert(0, _Finder())
    _install_schemas()


def _install_schemas() -> None:
    """`from pxr import PhysxSchema, Semantics`: usd-core has neither, so ours are set on the package."""
    import pxr

    from usdsdg.stage.schemas import physx, semantics_schema

    for name, module in (("PhysxSchema", physx), ("Semantics", semantics_schema)):
        if not hasattr(pxr, name):
            setattr(pxr, name, module)
            sys.modules[f"pxr.{name}"] = module
