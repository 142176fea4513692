"""Names that a module of the API does not have: where they are, or what does that work."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from types import ModuleType
from typing import Any

from usdsdg.arguments.registry import near_misses, registered_functions
from usdsdg.errors import MissingName

FAMILIES = (
    "create", "get", "modify", "randomizer", "distribution", "trigger", "physics", "orchestrator", "settings", "utils",
    "annotators", "writers", "backends", "rng",
)  # fmt: skip
_REGISTERING = ("create", "get", "modify", "randomizer", "distribution", "trigger")
# What scripts ask for by another word.
_LIKELY = {
    "modify": {
        "position": "modify.pose(position=...)",
        "translate": "modify.pose(position=...)",
        "translation": "modify.pose(position=...)",
        "rotation": "modify.pose(rotation=...)",
        "rotate": "modify.pose(rotation=...)",
        "scale": "modify.pose(scale=...)",
        "size": "modify.pose(size=...)",
        "look_at": "modify.pose(look_at=...)",
        "intensity": "modify.attribute('intensity', ...)",
    },
    "randomizer": {
        "pose": "modify.pose",
        "position": "modify.pose(position=distribution.uniform(...))",
        "scale": "modify.pose(scale=distribution.uniform(...))",
        "light": "create.light, with distributions, in a function that randomizer.register is given",
        "lights": "create.light, with distributions, in a function that randomizer.register is given",
        "objects": "randomizer.instantiate, which returns a population of assets,",
    },
    "utils": {"AttrMap": "modify.attribute"},
    "create": {"box": "create.cube", "dome_light": "create.light(light_type='dome')", "ground_plane": "create.plane"},
    "distribution": {
        "gaussian": "distribution.normal", "random": "distribution.uniform", "constant": "the value itself",
        "discrete": "distribution.choice", "range": "distribution.uniform",
    },
    "trigger": {"on_step": "trigger.on_frame", "on_interval": "trigger.on_frame(interval=...)"},
}  # fmt: skip


def hint(module: str, name: str, known: Iterable[str]) -> str:
    """Return "; ..." with where a name is that a module does not have, what does its work, or similar ones; or "".

    module: the module's own name; those of Replicator's API know of each other. known: the public names of it.
    """
    family = _family_of(module)
    if family is None:
        return similar(name, known)
    return _in_family(family, name, known)


def similar(name: str, known: Iterable[str]) -> str:
    """Return "; did you mean ...?" with the names of `known` that are similar; or ""."""
    near = near_misses(name, known, count=2)
    return f"; did you mean {' or '.join(near)}?" if near else ""


def public_names(module: Mapping[str, Any]) -> list[str]:
    """Return the public names of a module, from its globals."""
    return list(module.get("__all__") or (each for each in module if not each.startswith("_")))


def is_of_api(module: str) -> bool:
    """Return whether a module, by its own name, is one of Replicator's API, whose names `hint` knows."""
    return _family_of(module) is not None


def _family_of(module: str) -> str | None:
    """Return the family that a module is, "" for the root, None for a module of other names."""
    family = module.removeprefix("usdsdg").removeprefix(".")
    return family if module.startswith("usdsdg") and family in ("", *FAMILIES) else None


def _in_family(family: str, name: str, known: Iterable[str]) -> str:
    if name.startswith("_"):  # which Python and others ask for, and need no answer
        return ""
    if likely := _LIKELY.get(family, {}).get(name):
        return f"; {_named(likely)} does that"
    elsewhere = [each for each in FAMILIES if each != family and name != "register" and name in _public(each)]
    if not family:
        elsewhere = elsewhere or [each for each in _REGISTERING if name in registered_functions(each)]
        joined, _, member = name.partition("_")
        if joined in FAMILIES and member in _public(joined):
            return f"; it is rep.{joined}.{member}"
    elif name in getattr(sys.modules["usdsdg"], "__all__", ()):
        return f"; it is rep.{name}"
    if elsewhere:
        return f"; it is {' or '.join(f'rep.{each}.{name}' for each in elsewhere)}"
    found = similar(name, known)
    if family == "randomizer":
        found += (
            f"{'' if found else ';'} a function of the script is called so once it is registered: "
            f"rep.randomizer.register({name})"
        )
    return found


def explaining(module: dict[str, Any]) -> Callable[[str], Any]:
    """Return a `__getattr__` for a module of the API, from its globals, whose error says where a name is."""
    full = module["__name__"]

    def __getattr__(name: str) -> Any:
        raise lacking(sys.modules[full], name)

    return __getattr__


def lacking(module: ModuleType, name: str) -> AttributeError:
    """Return the error for a name that a module of the API does not have, under whatever name it was imported."""
    message = MissingName(module.__name__, name, partial(_hint_in, module.__name__, name))
    return AttributeError(message, name=name, obj=module)


def _hint_in(module: str, name: str) -> str:
    return hint(module, name, public_names(vars(sys.modules[module])))


def is_explained(module: ModuleType) -> bool:
    """Return whether a module's `__getattr__` is one of `explaining`."""
    own = vars(module).get("__getattr__")
    return getattr(own, "__module__", "") == __name__


def _named(likely: str) -> str:
    return likely if likely.startswith("the ") else f"rep.{likely}"


def _public(family: str) -> list[str]:
    module = getattr(sys.modules["usdsdg"], family)
    return module.__all__ if hasattr(module, "__all__") else [each for each in vars(module) if not each.startswith("_")]
