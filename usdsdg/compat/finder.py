"""Import hook that resolves `omni.x` to `usdsdg.compat.omni.x`, and `omni.replicator.core` to `usdsdg`.

Both names give the same module object, so there is one registry and one stage. The hook is first on `sys.meta_path`:
if it were last, a submodule would be found through its parent's path and loaded twice.
"""

from __future__ import annotations

import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import os
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

from usdsdg.arguments import misplaced
from usdsdg.arguments.registry import near_misses
from usdsdg.compat import foreign_names, imported_names
from usdsdg.compat.aliases import ALIASES
from usdsdg.compat.placeholders import PlaceholderModule, placeholder
from usdsdg.errors import Unsupported
from usdsdg.session import stage_context
from usdsdg.session.settings.replicator_version import note_old_import

ROOTS = ("omni", "carb", "usdrt", "isaacsim")
# Common words: a module of this name beside the script, or an installed one, comes first.
WEAK_ROOTS = ("semantics", "Semantics", "video_encoding")
# Replicator's modules import its utilities, and scripts take these from there: `create.ReplicatorItem`.
_FAMILIES = {
    f"usdsdg.{name}"
    for name in ("create", "distribution", "get", "modify", "orchestrator", "physics", "randomizer", "trigger")
}
# Modules that Isaac Sim has until version 4 only: their scripts expect the payloads of that time.
OLD_NAMES = ("omni.isaac.", "omni.replicator.isaac")


def real_name(name: str) -> str:
    """Return the name of the usdsdg module that a foreign name resolves to."""
    for prefix, target in ALIASES:
        if name == prefix or name.startswith(prefix + "."):
            return target + name[len(prefix) :]
    return f"usdsdg.compat.{name}"


# By the real names of the modules that were imported under a foreign one.
_foreign_names: dict[str, str] = {}


class _Loader(importlib.abc.Loader):
    """Returns the real module and keeps its `__spec__` and `__loader__`."""

    def __init__(self, name: str, real: str) -> None:
        self._name, self._real = name, real

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> ModuleType:
        module = importlib.import_module(self._real)
        self._import_attributes = (module.__spec__, module.__loader__)
        return module

    def exec_module(self, module: ModuleType) -> None:
        module.__spec__, module.__loader__ = self._import_attributes
        _foreign_names.setdefault(self._real, self._name)
        explained = misplaced.is_explained(module)
        if explained or "__getattr__" not in vars(module):
            module.__getattr__ = _explain_attributes(self._name, module, explained=explained)


class _MadeLoader(importlib.abc.Loader):
    """Returns a module without a file: a placeholder, or the parent of others."""

    def __init__(self, module: ModuleType) -> None:
        self._module = module

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> ModuleType:
        return self._module

    def exec_module(self, module: ModuleType) -> None: ...


class _Finder(importlib.abc.MetaPathFinder):
    def find_spec(self, name: str, path: object = None, target: object = None) -> importlib.machinery.ModuleSpec | None:
        if not _is_foreign(name):
            return _refuse_missing_name(name)
        if found := _found(name):
            return found
        raise ModuleNotFoundError(_missing(name), name=name)


def _is_foreign(name: str) -> bool:
    root = name.split(".", 1)[0]
    return root in ROOTS or (root in WEAK_ROOTS and _is_ours(root))


def _found(name: str) -> importlib.machinery.ModuleSpec | None:
    real = real_name(name)
    if name.startswith(OLD_NAMES) and (_exists(real) or foreign_names.out_of_scope(name)):
        note_old_import()
    if _exists(real):
        return importlib.machinery.ModuleSpec(name, _Loader(name, real), is_package=True)
    if own := _of_the_script(name):
        return own
    if subject := foreign_names.out_of_scope(name):
        return _made(PlaceholderModule(name, subject))
    if foreign_names.holds_out_of_scope(name):
        return _made(ModuleType(name, "Parent of modules that are out of scope."))
    return None


def lacks(name: str) -> bool:
    """Return whether there is no module of a foreign name; unlike its import, this looks for no similar names."""
    return name not in sys.modules and _is_foreign(name) and _found(name) is None


def _is_ours(root: str) -> bool:
    """Whether there is no other module of this name."""
    loaded = sys.modules.get(root)
    if loaded is not None:
        return loaded.__name__.startswith("usdsdg.")
    return importlib.machinery.PathFinder.find_spec(root) is None


def _exists(real: str) -> bool:
    parent = real.rpartition(".")[0]
    if not parent:
        return True  # usdsdg itself
    try:
        package = importlib.import_module(parent)
    except ModuleNotFoundError:
        return False
    return _is_file_of(package, real)


def _of_the_script(name: str) -> importlib.machinery.ModuleSpec | None:
    """Return the script's own module of this name: extensions have names such as `omni.mine` and `isaacsim.mine`."""
    parents = name.split(".")[:-1]
    if not parents:
        return None
    found = importlib.machinery.PathFinder.find_spec(name, [str(Path(entry, *parents)) for entry in sys.path])
    if found is None or found.loader is not None:
        return found
    # A folder without __init__.py is a package too, but only with modules in it one that is meant.
    holds_modules = any(any(Path(folder).rglob("*.py")) for folder in found.submodule_search_locations or ())
    return found if holds_modules else None


def _is_file_of(package: ModuleType, name: str) -> bool:
    return importlib.machinery.PathFinder.find_spec(name, vars(package).get("__path__", [])) is not None


def _made(module: ModuleType) -> importlib.machinery.ModuleSpec:
    return importlib.machinery.ModuleSpec(module.__name__, _MadeLoader(module), is_package=True)


def _missing(name: str) -> str:
    if moved := foreign_names.moved(name):
        return f"{name}: this module is not in usdsdg; what it does is elsewhere: {moved.where}."
    near = near_misses(name, known_modules())
    hint = f"Did you mean {' or '.join(near)}? " if near else ""
    return (
        f"{name}: this module of Isaac Sim or Omniverse has no counterpart in usdsdg yet. {hint}"
        "docs/compatibility.md lists what there is; if the script needs only a small part of it, guard the import."
    )


def known_modules() -> list[str]:
    """Return the foreign names of all modules that can be imported and work, sorted."""
    root = Path(__file__).parent
    files = (
        path.relative_to(root).with_suffix("").parts
        for top in (*ROOTS, *WEAK_ROOTS)
        for path in root.glob(f"{top}*/**/*.py")
    )
    single = [(path.stem,) for path in root.glob("*.py") if path.stem in (*ROOTS, *WEAK_ROOTS)]
    found = {".".join(parts[:-1] if parts[-1] == "__init__" else parts) for parts in [*files, *single]}
    return sorted(found | {prefix for prefix, _ in ALIASES})


def _explain_attributes(name: str, module: ModuleType, *, explained: bool) -> Callable[[str], object]:
    """Return a module's `__getattr__`: submodules, placeholders, and errors with the foreign and similar names.

    explained: the module is one of the API and has errors of its own, which stay those that they are without this.
    """

    def __getattr__(attribute: str) -> object:
        if attribute.startswith("__"):
            raise AttributeError(attribute)
        if _exists(real_name(f"{name}.{attribute}")):
            # In the application all modules are loaded, so `import omni` gives `omni.usd`.
            return importlib.import_module(f"{name}.{attribute}")
        if subject := foreign_names.out_of_scope(f"{name}.{attribute}"):
            return placeholder(f"{name}.{attribute}", subject)
        if module.__name__ in _FAMILIES and attribute in (utilities := importlib.import_module("usdsdg.utils")).__all__:
            return getattr(utilities, attribute)
        if place := imported_names.place_of(module.__name__, attribute):
            return getattr(importlib.import_module(place[0]), place[1])
        if explained:
            raise misplaced.lacking(module, attribute)
        raise AttributeError(_lacks(name, module, attribute), name=attribute, obj=module)

    return __getattr__


def _lacks(name: str, module: ModuleType, attribute: str) -> str:
    if moved := foreign_names.moved(f"{name}.{attribute}"):
        return f"{name} of usdsdg has no {attribute!r}; its work is done elsewhere: {moved.where}"
    public = misplaced.public_names(vars(module))
    told = misplaced.hint(module.__name__, attribute, public)
    if not told and not misplaced.is_of_api(module.__name__):
        told = f"; it has {', '.join(sorted(public)) or 'nothing yet'}"
    return f"{name} of usdsdg has no {attribute!r}{told}"


def _refuse_missing_name(name: str) -> None:
    """Raise an error with the foreign name where `from omni.x import y` asks for what `omni.x` does not have.

    Python looks for a submodule `usdsdg.compat.omni.x.y` then, which is not there, and drops the message of the module.

    Raises:
        ModuleNotFoundError: a module that was imported by a foreign name has neither such a name nor such a submodule.
    """
    parent, _, last = name.rpartition(".")
    module = sys.modules.get(parent)
    if module is not None and parent in _foreign_names and not _is_file_of(module, name):
        # With the module's own name, Python would take it for a failed look-up and drop it.
        foreign = _foreign_names[parent]
        raise ModuleNotFoundError(_lacks(foreign, module, last), name=f"{foreign}.{last}")


def is_installed() -> bool:
    """Return whether the foreign names are importable."""
    return any(isinstance(finder, _Finder) for finder in sys.meta_path)


def install() -> None:
    """Make the foreign names importable.

    Raises:
        Unsupported: Omniverse itself is importable in this environment, and its modules must not mix with ours.
    """
    stage_context.show_viewport()
    if is_installed():
        return
    # In a process that a script has started, `children.sitecustomize` would answer for Omniverse.
    sys.meta_path[:] = [each for each in sys.meta_path if not getattr(each, "installs_foreign_names", False)]
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
    _set_environment()


def _set_environment() -> None:
    """Set the variables that scripts build paths of experience files from; the files are not there, nor read."""
    for name in ("CARB_APP_PATH", "EXP_PATH", "ISAAC_PATH"):
        os.environ.setdefault(name, str(Path(__file__).parent))


def _wrap_pxr() -> None:
    """Make pxr's own calls take the asset URLs that Omniverse's resolver opens."""
    from usdsdg.compat import pxr_assets

    pxr_assets.install()


def _install_schemas() -> None:
    """Add to `pxr` what usd-core does not have."""
    import pxr

    for name, module in schemas().items():
        if not hasattr(pxr, name):
            setattr(pxr, name, module)
            sys.modules[f"pxr.{name}"] = module


def schemas() -> dict[str, ModuleType]:
    """Return our schemas and `PhysicsSchemaTools`, by their names in `pxr`."""
    from usdsdg.compat import physics_schema_tools
    from usdsdg.stage.schemas import physx, scripting_schema, semantics_schema

    return {
        "PhysxSchema": physx,
        "Semantics": semantics_schema,
        "OmniScriptingSchema": scripting_schema,
        "PhysicsSchemaTools": physics_schema_tools,
    }
