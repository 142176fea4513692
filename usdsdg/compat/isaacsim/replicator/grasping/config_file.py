"""The components of a `GraspingManager` in a configuration file, each checked when it is read."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pxr import Gf, Usd, UsdPhysics

from usdsdg.session.stage_context import current_stage

if TYPE_CHECKING:
    from usdsdg.compat.isaacsim.replicator.grasping.grasping_manager import GraspingManager

COMPONENTS = ("gripper", "phases", "pregrasp", "object", "poses", "sampler")
_KEYS = {
    "gripper": "gripper_path",
    "phases": "grasp_phases",
    "pregrasp": "joint_pregrasp_states",
    "object": "object_path",
    "poses": "grasp_poses",
    "sampler": "sampler_config",
}

_log = logging.getLogger("usdsdg.script")


class _Wrong(Exception):
    """What is wrong with a component; the message is its status."""


# --- to a file ---
def to_mapping(manager: GraspingManager, components: list[str] | None) -> dict[str, Any]:
    """Return the components that are set, as plain data."""
    poses = [
        {"position": list(location), "orientation": quat_to_mapping(orientation)}
        for location, orientation in manager.get_grasp_poses()
    ]
    values = {
        "gripper": manager.gripper_path,
        "phases": manager.get_grasp_phases_as_dicts(),
        "pregrasp": dict(manager.joint_pregrasp_states),
        "object": manager.get_object_prim_path(),
        "poses": poses,
        "sampler": {k: list(v) if isinstance(v, tuple) else v for k, v in manager.sampler_config.items()},
    }
    wanted = COMPONENTS if components is None else components
    return {_KEYS[name]: values[name] for name in COMPONENTS if name in wanted and values[name]}


def quat_to_mapping(quat: Gf.Quatd) -> dict[str, Any]:
    """Return w and xyz of a quaternion."""
    return {"w": quat.GetReal(), "xyz": list(quat.GetImaginary())}


# --- from a file ---
def load(manager: GraspingManager, config: Mapping[str, Any] | None, components: list[str] | None) -> dict[str, str]:
    """Set the components that a file has; return the status of each that is wanted."""
    wanted = [name for name in COMPONENTS if components is None or name in components]
    if config is None:
        return dict.fromkeys(wanted, "Failed (Could not read/parse file)")
    status = {}
    for name in wanted:
        if _KEYS[name] not in config:
            status[name] = "Not in file"
            continue
        try:
            status[name] = _LOADERS[name](manager, config[_KEYS[name]]) or "Success"
        except _Wrong as wrong:
            status[name] = f"Failed ({wrong})"
            _log.warning("grasping: %s was not loaded: %s", _KEYS[name], wrong)
    return status


def _load_gripper(manager: GraspingManager, value: Any) -> str:
    if not isinstance(value, str) or not manager.set_gripper(value):
        raise _Wrong(f"there is no prim {value!r}")
    return ""


def _load_phases(manager: GraspingManager, value: Any) -> str:
    phases = [each for each in _list(value) if isinstance(each, dict) and "name" in each]
    found = [each for each in phases if all(_is_joint(manager, path) for path in each.get("joint_drive_targets", {}))]
    manager.grasp_phases = []
    for phase in found:
        manager.create_and_add_grasp_phase(**phase)
    if not found:
        raise _Wrong(
            f"none of {len(_list(value))} phases drives only joints below the gripper {manager.gripper_path!r}"
        )
    left_out = len(_list(value)) - len(found)
    return f"Success (with validation warnings: {left_out} phases were left out)" if left_out else ""


def _load_pregrasp(manager: GraspingManager, value: Any) -> str:
    if not isinstance(value, dict):
        raise _Wrong("it is no mapping")
    manager.joint_pregrasp_states = {
        path: float(position)
        for path, position in value.items()
        if isinstance(position, (int, float)) and _is_joint(manager, path)
    }
    if not manager.joint_pregrasp_states:
        raise _Wrong(f"it has no joint below the gripper {manager.gripper_path!r}")
    if missing := sorted(value.keys() - manager.joint_pregrasp_states.keys()):
        _log.warning("grasping: these are no joints below %s: %s", manager.gripper_path, ", ".join(missing))
    return ""


def _load_object(manager: GraspingManager, value: Any) -> str:
    if not isinstance(value, str) or not current_stage().GetPrimAtPath(value):
        manager.clear_object()
        raise _Wrong(f"there is no prim {value!r}")
    manager.set_object_prim_path(value)
    return ""


def _load_poses(manager: GraspingManager, value: Any) -> str:
    manager.clear_grasp_poses()
    poses = []
    for each in _list(value):
        try:
            location = Gf.Vec3d(*each["position"])
            poses.append((location, Gf.Quatd(each["orientation"]["w"], Gf.Vec3d(*each["orientation"]["xyz"]))))
        except (KeyError, TypeError) as error:  # pxr's argument errors are TypeErrors
            _log.warning("grasping: a pose was left out, %s: %s", each, error)
    if not poses:
        raise _Wrong("it has no poses")
    manager.grasp_locations, manager.grasp_orientations = (list(each) for each in zip(*poses))
    return "" if len(poses) == len(value) else "Success (some entries skipped due to errors)"


def _load_sampler(manager: GraspingManager, value: Any) -> str:
    if not isinstance(value, dict):
        raise _Wrong("it is no mapping")
    known = {key: each for key, each in value.items() if key in manager.sampler_config}
    if unknown := sorted(value.keys() - known.keys()):
        _log.warning("grasping: the sampler has no setting %s", ", ".join(unknown))
    for key, each in known.items():
        kind = type(manager.sampler_config[key])
        fits = {tuple: (list, tuple), int: (int, float), float: (int, float)}.get(kind, (kind,))
        if type(each) not in fits:
            _log.warning("grasping: the sampler's %s is %r; expected a %s", key, each, kind.__name__)
            continue
        manager.sampler_config[key] = kind(each)
    if not known:
        raise _Wrong("it has no setting of the sampler")
    return ""


_LOADERS: dict[str, Callable[[Any, Any], str]] = {
    "gripper": _load_gripper,
    "phases": _load_phases,
    "pregrasp": _load_pregrasp,
    "object": _load_object,
    "poses": _load_poses,
    "sampler": _load_sampler,
}


def _list(value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise _Wrong("it is no list")
    return value


def _is_joint(manager: GraspingManager, path: str) -> bool:
    prim: Usd.Prim = current_stage().GetPrimAtPath(path)
    below = bool(manager.gripper_path) and str(path).startswith(f"{manager.gripper_path}/")
    return below and bool(prim) and prim.IsA(UsdPhysics.Joint)
