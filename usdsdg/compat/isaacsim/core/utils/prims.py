"""`isaacsim.core.utils.prims`: creating, finding and removing prims by path."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from usdsdg.compat import used_stage
from usdsdg.compat.isaacsim.core.experimental.utils import prim as newer
from usdsdg.compat.isaacsim.core.experimental.utils.stage import move_prim as move_prim_to
from usdsdg.compat.isaacsim.core.utils.semantics import add_labels
from usdsdg.compat.isaacsim.core.utils.stage import add_reference_to_stage, remove_prim
from usdsdg.compat.wrappers import poses
from usdsdg.compat.wrappers.arrays import pose_rows, rows
from usdsdg.compat.wrappers.prim_paths import existing_prim, from_wildcards
from usdsdg.errors import warn_once
from usdsdg.stage.attributes import attribute_of, set_value

PathPredicate = Callable[[str], bool]
# By the kinds of prims that `find_matching_prim_paths` tells apart, their schemas.
_KINDS = {"rigid_body": UsdPhysics.RigidBodyAPI, "articulation": UsdPhysics.ArticulationRootAPI}


# --- one prim ---
def get_prim_at_path(prim_path: str, fabric: bool = False) -> Usd.Prim:
    return used_stage.current_stage().GetPrimAtPath(prim_path)


def is_prim_path_valid(prim_path: str, fabric: bool = False) -> bool:
    """Whether there is a prim at this path."""
    return Sdf.Path.IsValidPathString(prim_path) and bool(get_prim_at_path(prim_path))


def define_prim(prim_path: str, prim_type: str = "Xform", fabric: bool = False) -> Usd.Prim:
    """Define a prim.

    Raises:
        ValueError: there is one already.
    """
    if is_prim_path_valid(prim_path):
        raise ValueError(f"there is a prim at {prim_path} already")
    return used_stage.current_stage().DefinePrim(prim_path, prim_type)


def create_prim(
    prim_path: str,
    prim_type: str = "Xform",
    position: Sequence[float] | None = None,
    translation: Sequence[float] | None = None,
    orientation: Sequence[float] | None = None,
    scale: Sequence[float] | None = None,
    usd_path: str | None = None,
    semantic_label: str | None = None,
    semantic_type: str = "class",
    attributes: Mapping[str, Any] | None = None,
) -> Usd.Prim:
    """Define a prim, reference a file on it, label and place it.

    Args:
        position: in the world [stage units]; `translation` is relative to the parent.
        orientation: (4,) w, x, y, z.
        attributes: Values of attributes that the type has.

    Raises:
        AssetError: the file is missing.
        ValueError: there is a prim already, or both position and translation are given.
    """
    if position is not None and translation is not None:
        raise ValueError("give either position or translation, not both")
    prim = define_prim(prim_path, prim_type)
    for name, value in (attributes or {}).items():
        if prim.HasAttribute(name):
            set_value(prim.GetAttribute(name), value)
        else:
            warn_once(f"create_prim: {prim_path} has no attribute {name!r}, which is ignored")
    if usd_path is not None:
        add_reference_to_stage(usd_path, prim_path)
    if semantic_label is not None:
        add_labels(prim, [semantic_label], semantic_type)
    if prim.IsA(UsdGeom.Xformable):
        _place(prim, position, translation, orientation, scale)
    return prim


def delete_prim(prim_path: str) -> None:
    """Remove a prim; one that a reference brings is turned off."""
    remove_prim(existing_prim(prim_path))


def move_prim(path_from: str, path_to: str) -> None:
    move_prim_to(path_from, path_to)


def get_prim_path(prim: Usd.Prim) -> str | None:
    return str(prim.GetPath()) if prim else None


def get_prim_type_name(prim_path: str, fabric: bool = False) -> str:
    return str(existing_prim(prim_path).GetTypeName())


def get_prim_object_type(prim_path: str) -> str | None:
    """Return "articulation", "rigid_body", "joint", "d6joint", "xform" or None."""
    prim = existing_prim(prim_path)
    named = (UsdPhysics.PrismaticJoint, UsdPhysics.RevoluteJoint, UsdPhysics.SphericalJoint)
    tests = {
        "articulation": prim.HasAPI(UsdPhysics.ArticulationRootAPI),
        "rigid_body": prim.HasAPI(UsdPhysics.RigidBodyAPI),
        "joint": any(prim.IsA(each) for each in named),
        "d6joint": prim.IsA(UsdPhysics.Joint),
        "xform": prim.IsA(UsdGeom.Xformable),
    }
    return next((name for name, holds in tests.items() if holds), None)


# --- parents and children ---
def get_prim_children(prim: Usd.Prim) -> list[Usd.Prim]:
    return prim.GetChildren()


def get_prim_parent(prim: Usd.Prim) -> Usd.Prim:
    return prim.GetParent()


def get_all_matching_child_prims(
    prim_path: str, predicate: PathPredicate = lambda path: True, depth: int | None = None
) -> list[Usd.Prim]:
    """Return the prim and those below whose path fulfils `predicate`, those nearer to the prim first."""
    return newer.get_all_matching_child_prims(
        prim_path, predicate=lambda _, path: predicate(path), include_self=True, max_depth=depth
    )


def get_first_matching_child_prim(prim_path: str, predicate: PathPredicate, fabric: bool = False) -> Usd.Prim | None:
    """Return the prim or the nearest one below whose path fulfils `predicate`."""
    return next(iter(get_all_matching_child_prims(prim_path, predicate)), None)


def get_first_matching_parent_prim(prim_path: str, predicate: PathPredicate) -> Usd.Prim | None:
    """Return the nearest prim above whose path fulfils `predicate`."""
    return newer.get_first_matching_parent_prim(prim_path, predicate=lambda _, path: predicate(path))


def query_parent_path(prim_path: str, predicate: PathPredicate) -> bool:
    """Whether the path of a prim above fulfils `predicate`."""
    return get_first_matching_parent_prim(prim_path, predicate) is not None


def find_matching_prim_paths(prim_path_regex: str, prim_type: str | None = None) -> list[str]:
    """Return the paths of prims that match a path with wildcards: "*" or ".*", "?", and "[1-3]" for one of several.

    prim_type: "rigid_body" or "articulation", for bodies or roots of articulations alone; "" or None for all prims.

    Raises:
        ValueError: `prim_type` is something else.
    """
    if prim_type and prim_type not in _KINDS:
        raise ValueError(
            f"prim_type is {prim_type!r}; expected {' or '.join(map(repr, _KINDS))}, or none for all prims"
        )
    found = newer.find_matching_prim_paths(from_wildcards(prim_path_regex))
    return [path for path in found if not prim_type or get_prim_at_path(path).HasAPI(_KINDS[prim_type])]


def is_prim_root_path(prim_path: str) -> bool:
    return prim_path == "/"


def is_prim_ancestral(prim_path: str) -> bool:
    """Whether a reference on a prim above brings the prim."""
    prim = existing_prim(prim_path)
    arcs = Usd.PrimCompositionQuery(prim).GetCompositionArcs()
    return any(arc.IsAncestral() for arc in arcs)


def get_articulation_root_api_prim_path(prim_path: str) -> str:
    """Return the path of the first prim at or below one that is the root of an articulation; else the path itself.

    Of a path with wildcards, the first prim that it names decides on what is added to the path.
    """
    first = next(iter(find_matching_prim_paths(prim_path)), None)
    for prim in Usd.PrimRange(get_prim_at_path(first)) if first else ():
        if prim.HasAPI(UsdPhysics.ArticulationRootAPI):
            return prim_path + str(prim.GetPath()).removeprefix(first or "")
    return prim_path


def is_prim_non_root_articulation_link(prim_path: str) -> bool:
    return newer.is_prim_non_root_articulation_link(prim_path)


# --- attributes ---
def get_prim_attribute_names(prim_path: str, fabric: bool = False) -> list[str]:
    return newer.get_prim_attribute_names(prim_path)


def get_prim_attribute_value(prim_path: str, attribute_name: str, fabric: bool = False) -> Any:
    """Return a value; a vector or quaternion as a list, quaternions as x, y, z, w.

    Raises:
        BadPrim: there is no such prim or attribute.
    """
    value = attribute_of(existing_prim(prim_path), attribute_name).Get()
    if isinstance(value, (Gf.Quatd, Gf.Quatf, Gf.Quath)):
        return [*value.GetImaginary(), value.GetReal()]
    return list(value) if getattr(type(value), "dimension", None) in (2, 3, 4) else value


def set_prim_attribute_value(prim_path: str, attribute_name: str, value: Any, fabric: bool = False) -> None:
    """Set a value; numbers may be a list or an array.

    Raises:
        BadPrim: there is no such prim or attribute.
        BadValue: the attribute does not take the value.
    """
    set_value(attribute_of(existing_prim(prim_path), attribute_name), value)


def get_prim_property(prim_path: str, property_name: str) -> Any:
    return attribute_of(existing_prim(prim_path), property_name).Get()


def set_prim_property(prim_path: str, property_name: str, property_value: Any) -> None:
    set_value(attribute_of(existing_prim(prim_path), property_name), property_value)


def set_targets(prim: Usd.Prim, attribute: str, target_prim_paths: Sequence[str]) -> None:
    """Set the targets of a relationship."""
    prim.CreateRelationship(attribute).SetTargets([Sdf.Path(str(path)) for path in target_prim_paths])


def set_prim_visibility(prim: Usd.Prim, visible: bool) -> None:
    imageable = UsdGeom.Imageable(prim)
    imageable.MakeVisible() if visible else imageable.MakeInvisible()


# --- marks for the application's windows, kept in the prim's custom data ---
def is_prim_no_delete(prim_path: str) -> bool:
    return bool(existing_prim(prim_path).GetCustomDataByKey("no_delete"))


def set_prim_no_delete(prim: Usd.Prim, no_delete: bool) -> None:
    prim.SetCustomDataByKey("no_delete", bool(no_delete))


def is_prim_hidden_in_stage(prim_path: str) -> bool:
    return bool(existing_prim(prim_path).GetCustomDataByKey("hide_in_stage_window"))


def set_prim_hide_in_stage_window(prim: Usd.Prim, hide: bool) -> None:
    prim.SetCustomDataByKey("hide_in_stage_window", bool(hide))


def _place(
    prim: Usd.Prim,
    position: Sequence[float] | None,
    translation: Sequence[float] | None,
    orientation: Sequence[float] | None,
    scale: Sequence[float] | None,
) -> None:
    """Give a prim the ops translate, orient and scale, and set those that are given."""
    poses.reset_ops([prim])
    if translation is not None:
        poses.set_local_poses([prim], *pose_rows(translation, orientation, 1))
    elif position is not None or orientation is not None:
        poses.set_world_poses([prim], *pose_rows(position, orientation, 1))
    if scale is not None:
        poses.set_local_scales([prim], rows(scale, 3, 1))
