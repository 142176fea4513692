"""`isaacsim.replicator.behavior.utils.behavior_utils`: scripts on prims, and the variables that they expose.

A variable is an attribute `exposedVar:<behavior>:<variable>` of the script's prim.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from typing import Any

from pxr import Sdf, Usd

from usdsdg.app.app import get_app
from usdsdg.compat.carb.eventdispatcher import Event, get_eventdispatcher
from usdsdg.compat.isaacsim.replicator.behavior.global_variables import EXPOSED_VARS_CHANGED_EVENT
from usdsdg.compat.omni.behavior.scripting.core import get_script_manager
from usdsdg.compat.omni.behavior.scripting.script_manager import SCRIPTS

_log = logging.getLogger("usdsdg.script")

# Updates after which a script that was attached has exposed its variables.
_UPDATES_TO_ATTACH = 3


# --- exposed variables ---
def create_exposed_variable(
    prim: Usd.Prim, full_attr_name: str, attr_type: Sdf.ValueTypeName, default_value: object, doc: str | None = None
) -> Usd.Attribute:
    """Return the attribute of that name; where there is none, create it with its default and documentation."""
    if attribute := prim.GetAttribute(full_attr_name):
        return attribute
    attribute = prim.CreateAttribute(full_attr_name, attr_type)
    attribute.Set(default_value)
    if doc:
        attribute.SetDocumentation(doc)
    return attribute


def create_exposed_variables(
    prim: Usd.Prim, exposed_attr_ns: str, behavior_ns: str, variables_to_expose: Sequence[Mapping[str, Any]]
) -> None:
    """Create an attribute for each variable: a mapping with attr_name, attr_type, default_value, doc, lock.

    `lock`, which keeps users from editing an attribute in the user interface, has no effect.
    """
    for variable in variables_to_expose:
        create_exposed_variable(
            prim,
            f"{exposed_attr_ns}:{behavior_ns}:{variable['attr_name']}",
            variable["attr_type"],
            variable["default_value"],
            variable.get("doc"),
        )
    _notify()


def get_exposed_variable(prim: Usd.Prim, full_attr_name: str) -> Any:
    """Return the value of an exposed variable; None if there is no such attribute or prim."""
    if not prim:
        _log.warning("an invalid prim has no exposed variable %s", full_attr_name)
        return None
    attribute = prim.GetAttribute(full_attr_name)
    return attribute.Get() if attribute else None


def set_exposed_variables(prim: Usd.Prim, exposed_variables: Mapping[str, Any]) -> None:
    """Set exposed variables by the full names of their attributes; names that do not exist are logged."""
    if not prim:
        _log.warning("an invalid prim has no exposed variables")
        return
    for name, value in exposed_variables.items():
        if attribute := prim.GetAttribute(name):
            attribute.Set(value)
        else:
            _log.warning("%s has no exposed variable %s", prim.GetPath(), name)


def remove_exposed_variable(prim: Usd.Prim, full_attr_name: str, remove_from_fabric: bool = True) -> None:
    """Remove the attribute of an exposed variable; there is no Fabric to remove it from."""
    if not prim or not prim.GetAttribute(full_attr_name):
        _log.warning("%s has no exposed variable %s", prim.GetPath() if prim else "an invalid prim", full_attr_name)
        return
    prim.RemoveProperty(full_attr_name)


def remove_exposed_variables(
    prim: Usd.Prim, exposed_attr_ns: str, behavior_ns: str, variables_to_expose: Sequence[Mapping[str, Any]]
) -> None:
    """Remove the attributes that `create_exposed_variables` made."""
    for variable in variables_to_expose:
        remove_exposed_variable(prim, f"{exposed_attr_ns}:{behavior_ns}:{variable['attr_name']}")
    _notify()


def check_if_exposed_variables_should_be_removed(prim: Usd.Prim, script_file_path: str) -> bool:
    """Return whether a prim, which must be valid, no longer names the script."""
    if not prim:
        return False
    return script_file_path not in _script_paths(prim)


def _notify() -> None:
    get_eventdispatcher().dispatch_event(EXPOSED_VARS_CHANGED_EVENT, {})


# --- scripts ---
def add_behavior_script(prim: Usd.Prim, script_path: str, allow_duplicates: bool = False) -> None:
    """Attach a Python file to a prim; it starts at the next update. One that is attached is not attached again."""
    if not prim:
        _log.warning("an invalid prim takes no behavior script")
        return
    get_script_manager()
    attribute = prim.GetAttribute(SCRIPTS)
    if not attribute:
        prim.AddAppliedSchema("OmniScriptingAPI")
        attribute = prim.CreateAttribute(SCRIPTS, Sdf.ValueTypeNames.AssetArray)
    paths = _script_paths(prim)
    if allow_duplicates or script_path not in paths:
        attribute.Set(Sdf.AssetPathArray([*paths, script_path]))


async def add_behavior_script_with_parameters_async(
    prim: Usd.Prim,
    script_path: str,
    exposed_variables: Mapping[str, Any] | None = None,
    allow_duplicates: bool = False,
) -> None:
    """Attach a Python file to a prim, wait until it has exposed its variables, and set them by their full names."""
    if not prim:
        _log.warning("an invalid prim takes no behavior script")
        return
    add_behavior_script(prim, script_path, allow_duplicates)
    for _ in range(_UPDATES_TO_ATTACH):
        await get_app().next_update_async()
    set_exposed_variables(prim, exposed_variables or {})


def _script_paths(prim: Usd.Prim) -> list[str]:
    attribute = prim.GetAttribute(SCRIPTS)
    return [asset.path for asset in (attribute.Get() or [])] if attribute else []


# --- prims and events ---
def remove_empty_scopes(prim: Usd.Prim, stage: Usd.Stage) -> None:
    """Remove the scopes and untyped prims at and below `prim` that have no children left."""
    if not prim:
        return
    for child in prim.GetChildren():
        remove_empty_scopes(child, stage)
    if str(prim.GetTypeName()) in ("", "Scope") and not prim.GetChildren():
        stage.RemovePrim(prim.GetPath())


async def publish_event_and_wait_for_completion_async(
    publish_payload: Mapping[str, Any],
    expected_payload: Mapping[str, Any],
    publish_event_name: str,
    subscribe_event_name: str,
    max_wait_updates: int,
    verbose: bool = True,
) -> bool:
    """Dispatch an event and wait for another whose payload has all items of `expected_payload`.

    Returns:
        Whether it came within `max_wait_updates` application updates.
    """
    came = False

    def receive(event: Event) -> None:
        nonlocal came
        came = came or all(event.get(key) == value for key, value in expected_payload.items())
        if verbose:
            print(f"{subscribe_event_name}: {dict(event.payload)}")

    observer = get_eventdispatcher().observe_event(event_name=subscribe_event_name, on_event=receive)
    try:
        get_eventdispatcher().dispatch_event(publish_event_name, dict(publish_payload))
        for _ in range(max_wait_updates):
            if came:
                break
            await get_app().next_update_async()
    finally:
        observer.reset()
    if verbose and not came:
        print(f"{subscribe_event_name}: no event with {dict(expected_payload)} in {max_wait_updates} updates")
    return came
