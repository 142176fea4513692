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
from usdsdg.compat.placeholders import PlaceholderModule, placeholder
from usdsdg.errors import Unsupported
from usdsdg.session import stage_context
from usdsdg.session.replicator_version import note_old_import

ROOTS = ("omni", "carb", "usdrt", "isaacsim")
# Common words: a module of this name beside the script, or an installed one, comes first.
WEAK_ROOTS = ("semantics", "Semantics", "video_encoding")
_OLD_PRIM_MODULES = (
    "xform_prim", "xform_prim_view", "rigid_prim", "rigid_prim_view", "geometry_prim", "geometry_prim_view",
    "rigid_contact_view",
)  # fmt: skip
_WRITERS = "usdsdg.compat.isaacsim.replicator.writers"
_WRITER_PACKAGES = tuple(
    f"{extension}.scripts{part}"
    for extension in ("isaacsim.replicator.writers", "omni.replicator.isaac")
    for part in (".writers", "")
)
_WRITER_MODULES = (
    "data_visualization_writer", "dope_writer", "pose_writer", "pytorch_listener", "pytorch_writer", "ycb_video_writer",
)  # fmt: skip
# Longest prefix first. These names are modules of usdsdg itself, without a file in `usdsdg.compat`.
ALIASES = (
    ("omni.replicator.core.scripts.functional.io_functions", "usdsdg.writers.files"),
    ("omni.replicator.core.functional.io_functions", "usdsdg.writers.files"),
    ("omni.replicator.core.scripts.utils.rng", "usdsdg.rng"),
    ("omni.replicator.core.utils.rng", "usdsdg.rng"),
    ("omni.replicator.core.bindings._omni_replicator_core", "usdsdg.compat.omni.replicator.telemetry"),
    ("omni.replicator.core.bindings", "usdsdg.compat.omni.replicator"),
    *(
        (f"omni.replicator.core{part}", f"usdsdg.compat.omni.replicator.{name}")
        for name, parts in (
            ("io_queue", (".scripts.backends.io_queue", ".backends.io_queue")),
            ("annotator_utils", (".scripts.utils.annotator_utils", ".utils.annotator_utils")),
        )
        for part in parts
    ),
    # The modules of the backends are one.
    *(
        (f"omni.replicator.core{part}.backends.{name}", "usdsdg.backends")
        for part in (".scripts", "")
        for name in ("base", "disk", "dispatcher", "group", "registry", "s3", "sequential")
    ),
    # As the modules of the registries were named at first.
    ("omni.replicator.core.scripts.annotator_registry", "usdsdg.annotators"),
    ("omni.replicator.core.scripts.writer_registry", "usdsdg.writers"),
    ("omni.replicator.core.scripts", "usdsdg"),
    ("omni.replicator.core", "usdsdg"),
    ("omni.replicator.replicator_yaml", "usdsdg.replicator_yaml"),
    *(
        (f"{extension}.scripts.utils", "usdsdg.compat.isaacsim.replicator.writer_utils")
        for extension in ("isaacsim.replicator.writers", "omni.replicator.isaac")
    ),
    # The modules of the writers, one per class, and their packages are one module.
    *((f"{package}.{name}", _WRITERS) for package in _WRITER_PACKAGES for name in _WRITER_MODULES),
    *((package, _WRITERS) for package in _WRITER_PACKAGES),
    ("omni.replicator.isaac", "usdsdg.compat.isaacsim.replicator.domain_randomization"),
    ("omni.usd.commands", "usdsdg.compat.omni.kit.commands.command_classes"),
    ("omni.usd._impl.utils", "usdsdg.compat.omni.usd"),
    ("omni.usd._impl", "usdsdg.compat.omni.usd"),
    ("omni.kit.scripting", "usdsdg.compat.omni.behavior.scripting.core"),
    ("omni.isaac.sensor._sensor", "usdsdg.compat.isaacsim.sensors.physics._sensor"),
    ("omni.isaac.sensor.scripts.camera", "usdsdg.compat.isaacsim.sensors.camera"),
    ("omni.isaac.sensor.scripts", "usdsdg.compat.omni.isaac.sensor"),
    ("omni.isaac.sensor", "usdsdg.compat.omni.isaac.sensor"),
    ("omni.syntheticdata.scripts.SyntheticData", "usdsdg.compat.omni.syntheticdata.synthetic_data"),
    ("omni.syntheticdata.scripts", "usdsdg.compat.omni.syntheticdata"),
    # Isaac Sim 4's names of the core. Modules below these packages, one per class, are the packages themselves.
    *((f"omni.isaac.core.prims.{name}", "usdsdg.compat.omni.isaac.core.prims") for name in _OLD_PRIM_MODULES),
    ("omni.isaac.core.prims", "usdsdg.compat.omni.isaac.core.prims"),
    *(
        (f"omni.isaac.core.articulations.{name}", "usdsdg.compat.omni.isaac.core.articulations")
        for name in ("articulation", "articulation_view", "articulation_subset", "articulation_gripper")
    ),
    ("omni.isaac.core.articulations", "usdsdg.compat.omni.isaac.core.articulations"),
    ("omni.isaac.core.utils", "usdsdg.compat.isaacsim.core.utils"),
    ("omni.isaac.core", "usdsdg.compat.isaacsim.core.api"),
    ("omni.isaac.cloner", "usdsdg.compat.isaacsim.core.cloner"),
    ("isaacsim.storage.native.nucleus", "usdsdg.compat.isaacsim.storage.native"),
    ("Semantics", "usdsdg.stage.schemas.semantics_schema"),
    ("omni.isaac.version", "usdsdg.compat.isaacsim.core.version"),
    ("isaacsim.core.simulation_manager.impl", "usdsdg.compat.isaacsim.core.simulation_manager"),
    ("isaacsim.core.prims.impl", "usdsdg.compat.isaacsim.core.prims"),
)
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
