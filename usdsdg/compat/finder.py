"""Import hook that resolves `omni.x` to `usdsdg.compat.omni.x`, and `omni.replicator.core` to `usdsdg`.

Both names give the same module object, so there is one registry and one stage. The hook is first on `sys.meta_path`:
if it were last, a submodule would be found through its parent's path and loaded twice.
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
# Longest prefix first. These names are modules of usdsdg itself, without a file in `usdsdg.compat`.
ALIASES = (
    ("omni.replicator.core.scripts", "usdsdg"),
    ("omni.replicator.core", "usdsdg"),
    ("omni.replicator.replicator_yaml", "usdsdg.replicator_yaml"),
    ("omni.kit.scripting", "usdsdg.compat.omni.behavior.scripting.core"),
)


def real_name(name: str) -> str:
    """Return the name of the usdsdg module that a foreign name resolves to."""
    for prefix, target in ALIASES:
        if name == prefix or name.startswith(prefix + "."):
            return target + name[len(prefix) :]
    return f"usdsdg.compat.{name}"


class _Loader(importlib.abc.Loader):
    """Returns the real module and keeps its `__spec__` and `__loader__`."""

    def __init__(self, real: str) -> None:
        self._real = real

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> ModuleType:
        module = importlib.import_module(self._real)
        self._import_attributes = (module.__spec__, module.__loader__)
        return module

    def exec_module(self, module: ModuleType) -> None:
        module.__spec__, module.__loader__ = self._import_attributes


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
    """Return whether the foreign names are importable."""
    return any(isinstance(finder, _Finder) for finder in sys.meta_path)


def install() -> None:
    """Make the foreign names importable.

    Raises:
        Unsupported: Omniverse itself is importable in this environment, and its modules must not mix with ours.
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
    _wrap_pxr()


def _wrap_pxr() -> None:
    """Make pxr's own calls take the asset URLs that Omniverse's resolver opens."""
    from usdsdg.compat import pxr_assets

    pxr_assets.install()


def _install_schemas() -> None:
    """Add our `PhysxSchema` and `Semantics`, which usd-core does not have, to the `pxr` package."""
    import pxr

    from usdsdg.stage.schemas import physx, semantics_schema

    for name, module in (("PhysxSchema", physx), ("Semantics", semantics_schema)):
        if not hasattr(pxr, name):
            setattr(pxr, name, module)
            sys.modules[f"pxr.{name}"] = module
