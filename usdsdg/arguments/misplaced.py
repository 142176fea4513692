"""Names that a module of the API does not have: where they are, or what does that work."""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any

from usdsdg.arguments.registry import near_misses, registered_functions

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
    },
    "create": {"box": "create.cube", "dome_light": "create.light(light_type='dome')", "ground_plane": "create.plane"},
    "distribution": {
        "gaussian": "distribution.normal", "random": "distribution.uniform", "constant": "the value itself",
        "discrete": "distribution.choice", "range": "distribution.uniform",
    },
    "trigger": {"on_step": "trigger.on_frame", "on_interval": "trigger.on_frame(interval=...)"},
}  # fmt: skip


def where(family: str, name: str, known: list[str]) -> str:
    """Return "; ..." with where a name is that `rep.<family>` does not have, or similar ones of `known`; or "".

    family: "create" and so on; "" for the root.
    """
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
    near = near_misses(name, known, count=2)
    hint = f"; did you mean {' or '.join(map(repr, near))}?" if near else ""
    if family == "randomizer":
        hint += (
            f"{'' if hint else ';'} a function of the script is called so once it is registered: "
            f"rep.randomizer.register({name})"
        )
    return hint


class Missing:
    """Message of the AttributeError for a name that a module does not have, made when somebody reads it.

    Python asks a package for names on its way to submodules, while the families are being imported.
    """

    def __init__(self, module: str, family: str, name: str, known: list[str]) -> None:
        self._module, self._family, self._name, self._known = module, family, name, known

    def __str__(self) -> str:
        return f"module {self._module!r} has no attribute {self._name!r}{where(self._family, self._name, self._known)}"

    __repr__ = __str__


def explaining(module: dict[str, Any]) -> Callable[[str], Any]:
    """Return a `__getattr__` for a module of the API, from its globals, whose error says where a name is."""
    full = module["__name__"]
    family = full.removeprefix("usdsdg.")

    def __getattr__(name: str) -> Any:
        known = [each for each in module.get("__all__") or module if not each.startswith("_")]
        raise AttributeError(Missing(full, family, name, known), name=name, obj=sys.modules[full])

    return __getattr__


def is_explained(module: ModuleType) -> bool:
    """Return whether a module's `__getattr__` is one of `explaining`."""
    own = vars(module).get("__getattr__")
    return getattr(own, "__module__", "") == __name__


def _named(likely: str) -> str:
    return likely if likely.startswith("the ") else f"rep.{likely}"


def _public(family: str) -> list[str]:
    module = getattr(sys.modules["usdsdg"], family)
    return module.__all__ if hasattr(module, "__all__") else [each for each in vars(module) if not each.startswith("_")]
