"""Commands that set and remove properties, metadata and settings."""

from __future__ import annotations

from typing import Any

from pxr import Sdf, Usd

from usdsdg.compat.omni.kit.commands.registry import command
from usdsdg.compat.wrappers.cameras import editable_layer
from usdsdg.errors import BadPrim
from usdsdg.session.settings.store import get_settings
from usdsdg.session.stage_context import current_stage

AnyPath = str | Sdf.Path


@command("ChangeProperty")
def change_property(
    prop_path: AnyPath,
    value: Any,
    prev: Any = None,
    timecode: Usd.TimeCode = Usd.TimeCode.Default(),  # noqa: B008
    type_to_create_if_not_exist: Sdf.ValueTypeName | None = None,
    target_layer: Sdf.Layer | None = None,
    is_custom: bool = False,
    variability: Sdf.Variability = Sdf.VariabilityVarying,
) -> None:
    """Set an attribute; one that is not there is created with `type_to_create_if_not_exist`.

    Raises:
        BadPrim: there is no such prim or attribute.
    """
    stage, path = current_stage(), Sdf.Path(str(prop_path))
    prim = stage.GetPrimAtPath(path.GetPrimPath())
    if not prim:
        raise BadPrim(f"ChangeProperty: {path.GetPrimPath()} is not on the stage")
    attribute = prim.GetAttribute(path.name)
    with Usd.EditContext(stage, target_layer or editable_layer(prim)):
        if not attribute:
            if type_to_create_if_not_exist is None:
                raise BadPrim(
                    f"ChangeProperty: {path.GetPrimPath()} has no attribute {path.name!r}; give "
                    "type_to_create_if_not_exist=Sdf.ValueTypeNames..."
                )
            attribute = prim.CreateAttribute(path.name, type_to_create_if_not_exist, is_custom, variability)
        if value is None:
            attribute.Clear()
        else:
            attribute.Set(value, timecode)


@command("CreateUsdAttribute")
def create_usd_attribute(
    prim: Usd.Prim,
    attr_name: str,
    attr_type: Sdf.ValueTypeName,
    custom: bool = True,
    variability: Sdf.Variability = Sdf.VariabilityVarying,
    attr_value: Any = None,
) -> None:
    """Create an attribute, with a value if one is given."""
    attribute = prim.CreateAttribute(attr_name, attr_type, custom, variability)
    if attr_value is not None:
        attribute.Set(attr_value)


@command("CreateUsdAttributeOnPath")
def create_usd_attribute_on_path(
    attr_path: AnyPath,
    attr_type: Sdf.ValueTypeName,
    custom: bool = True,
    variability: Sdf.Variability = Sdf.VariabilityVarying,
    attr_value: Any = None,
) -> None:
    """Create an attribute by its path, with a value if one is given.

    Raises:
        BadPrim: there is no such prim.
    """
    path = Sdf.Path(str(attr_path))
    prim = current_stage().GetPrimAtPath(path.GetPrimPath())
    if not prim:
        raise BadPrim(f"CreateUsdAttributeOnPath: {path.GetPrimPath()} is not on the stage")
    create_usd_attribute(prim, path.name, attr_type, custom, variability, attr_value)


@command("AddRelationshipTarget")
def add_relationship_target(
    relationship: Usd.Relationship, target: AnyPath, position: Usd.ListPosition = Usd.ListPositionBackOfPrependList
) -> None:
    """Add a target to a relationship."""
    relationship.AddTarget(Sdf.Path(str(target)), position)


@command("RemoveRelationshipTarget")
def remove_relationship_target(relationship: Usd.Relationship, target: AnyPath) -> None:
    """Remove a target of a relationship."""
    relationship.RemoveTarget(Sdf.Path(str(target)))


@command("RemoveProperty")
def remove_property(prop_path: AnyPath) -> None:
    """Remove what the stage's layers hold of a property."""
    path = Sdf.Path(str(prop_path))
    prim = current_stage().GetPrimAtPath(path.GetPrimPath())
    if prim:
        prim.RemoveProperty(path.name)


@command("ChangeMetadata")
def change_metadata(object_paths: list[AnyPath], key: str, value: Any) -> None:
    """Set metadata of prims or properties; None clears it."""
    for path in object_paths:
        target = current_stage().GetObjectAtPath(str(path))
        if not target:
            raise BadPrim(f"ChangeMetadata: {path} is not on the stage")
        target.ClearMetadata(key) if value is None else target.SetMetadata(key, value)


@command("ChangeSetting")
def change_setting(path: str, value: Any) -> None:
    """Set a setting."""
    get_settings().set(path, value)
