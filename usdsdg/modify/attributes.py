"""Attributes of prims: `rep.modify.attribute`."""

from collections.abc import Sequence
from typing import Any

from pxr import Sdf, Usd, UsdGeom, UsdShade

from usdsdg.arguments.prims import prim_at
from usdsdg.arguments.registry import near_misses
from usdsdg.arguments.values import shown, vector
from usdsdg.distribution import Distribution, draw, is_vector
from usdsdg.errors import ArgumentError, BadValue
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act
from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.modify.point_instances import is_per_instance, objects_of, set_per_instance
from usdsdg.modify.prims import non_xform_prims, target_prims
from usdsdg.stage import materials
from usdsdg.stage.attribute_batch import write_batch
from usdsdg.stage.attributes import set_value
from usdsdg.stage.cameras.lens_attributes import lens_attribute_type
from usdsdg.stage.geometry.instancers import instance_names, is_instancer, prototypes

_KINDS = [getattr(Sdf.ValueTypeNames, name) for name in dir(Sdf.ValueTypeNames)]
VALUE_TYPES = [str(kind) for kind in _KINDS if isinstance(kind, Sdf.ValueTypeName)]


def attribute_of(prim: Usd.Prim, name: str, attribute_type: str | None) -> Usd.Attribute:
    for candidate in (name, f"inputs:{name}"):
        if prim.HasAttribute(candidate):
            return prim.GetAttribute(candidate)
    if prim.GetTypeName() in ("Material", "Shader"):
        name = f"inputs:{name.removeprefix('inputs:')}"
    known = lens_attribute_type(name) if prim.IsA(UsdGeom.Camera) else materials.input_type(prim, name)
    if attribute_type is None and known:
        return prim.CreateAttribute(name, known, custom=False)
    if attribute_type is None:
        near = near_misses(name, [a.GetName() for a in prim.GetAttributes()])
        raise ArgumentError(
            f"{prim.GetPath()} has no attribute {name!r}"
            + (f"; similar: {', '.join(near[:5])}" if near else "")
            + ". Pass attribute_type to create it."
        )
    type_name = Sdf.ValueTypeNames.Find(attribute_type)
    if not type_name:
        near = near_misses(attribute_type, VALUE_TYPES)
        hint = f"; did you mean {' or '.join(near)}?" if near else " such as 'float' or 'color3f'"
        raise ArgumentError(f"attribute_type={attribute_type!r} is not a USD value type{hint}")
    return prim.CreateAttribute(name, type_name, custom=True)


def dimension(attribute: Usd.Attribute) -> int:
    """Return the number of components of a vector attribute; 0 for every other type."""
    size = getattr(type(attribute.GetTypeName().defaultValue), "dimension", 0)
    return size if isinstance(size, int) else 0


def set_attribute(prim: Usd.Prim, name: str, value: Any, attribute_type: str | None = None) -> None:
    """Set an attribute of the prim, or of an object's children if the prim itself does not have it.

    Raises:
        ArgumentError: there is no such attribute and no type for a new one, or it does not take the value.
        AssetNotFound: a string for an asset attribute is neither a file nor a URL of a file below the assets root.
    """
    for owner in owners_of(prim, name):
        target = attribute_of(owner, name, attribute_type)
        size = dimension(target)
        converted = vector(target.GetName().removeprefix("inputs:"), value, size) if size else value
        try:
            set_value(target, converted)
        except BadValue as error:
            raise ArgumentError(str(error)) from None
        _show(owner, name)


def _show(owner: Usd.Prim, name: str) -> None:
    if owner.GetTypeName() == "Shader":
        materials.show_in_preview(owner, name)


def owners_of(prim: Usd.Prim, name: str) -> list[Usd.Prim]:
    if prim.IsA(UsdShade.Material):
        return [materials.input_owner(prim, name)]
    if prim.HasAttribute(name) or prim.HasAttribute(f"inputs:{name}"):
        return [prim]
    return non_xform_prims(prim)


def attribute(name: str, value: Any, attribute_type: str | None = None, input_prims: Any = None) -> ReplicatorItem:
    """Set an attribute of the prims at each firing; of an object, the attribute of the child which has it.

    Of a material it is the input of that name of its shader. Inputs of OmniPBR, and attributes of a camera's lens such
    as cameraProjectionType, fthetaWidth and openCVFx, exist also where they have no value yet.
    Of a PointInstancer positions, orientations (real part first), scales, velocities, accelerations and
    angularVelocities get one value for each instance, as do the ops xformOp:translate, xformOp:rotateXYZ and
    xformOp:scale, which are those of each instance; what the instancer does not have is set on its prototypes.

    Args:
        name: of the attribute, `<name>` or `inputs:<name>`.
        value: one for all, a list of one per prim, or a distribution. Numbers are rounded down for integer attributes,
            and one number fills a vector. Strings for assets are files or URLs below the assets root.
        attribute_type: USD's name of a type, such as "float" or "color3f", to create an attribute that does not exist.

    Raises:
        ArgumentError: the name is no text.
        GraphError: at execution, a prim has no such attribute and no type is given, there is no such type, or the
            attribute does not take the value; the message names near misses and the script line.
    """
    if not isinstance(name, str):
        raise ArgumentError(f"modify.attribute: name is {shown(name)}; expected text, such as 'focalLength'")
    return act("OgnWritePrimAttribute", input_prims, attribute=name, value=value, attributeType=attribute_type)


@action("OgnWritePrimAttribute", "attributeType")
def _write_attribute(node: Node, execution: int) -> None:
    name, type_name = node.inputs["attribute"], node.inputs.get("attributeType")
    value = node.inputs["value"]
    if any(map(is_instancer, target_prims(node))):
        _write_to_objects(node, execution)
        return
    values = (
        _per_prim(name, value, target_prims(node), type_name)
        if isinstance(value, list)
        else draw(value, node, execution, "value")
    )

    def find() -> list[Usd.Attribute]:
        owners = [owners_of(prim, name) for prim in target_prims(node)]
        return [attribute_of(owner, name, type_name) for of_prim in owners for owner in of_prim]

    if len(values) == len(node.prims) and write_batch(node.state, "values", find, values):
        for prim in target_prims(node):
            if prim.GetTypeName() in ("Material", "Shader"):
                _show(owners_of(prim, name)[0], name)
        return
    for prim, drawn in zip(target_prims(node), values):
        set_attribute(prim, name, drawn, type_name)


def _write_to_objects(node: Node, execution: int) -> None:
    """Write an attribute of prims among which there are PointInstancers, see `attribute`."""
    name, type_name = node.inputs["attribute"], node.inputs.get("attributeType")
    value = node.inputs["value"]
    prims = target_prims(node)
    objects = objects_of(node, [attribute_objects(prim, name) for prim in prims])
    of_instances = is_per_instance(name)
    if isinstance(objects.node.inputs["value"], list) and not of_instances:
        owners = [prim_at(path) for path in objects.node.prims]
        drawn = _per_prim(name, objects.node.inputs["value"], owners, type_name)
    else:
        drawn = draw(objects.node.inputs["value"], objects.node, execution, "value")
    for prim, rows in zip(prims, objects.rows):
        if of_instances and is_instancer(prim):
            # Without protoIndices there are no instances yet, and the value is the whole array.
            if drawn[rows] or isinstance(value, Distribution):
                set_per_instance(prim, name, drawn[rows])
            else:
                set_attribute(prim, name, value, type_name)
            continue
        for path, one in zip(objects.node.prims[rows], drawn[rows]):
            set_attribute(prim_at(path), name, one, type_name)


def attribute_objects(prim: Usd.Prim, name: str) -> list[str]:
    """Return what has the attribute: the prim, or of a PointInstancer its instances or, if it has none, prototypes."""
    if not is_instancer(prim) or prim.HasAttribute(f"inputs:{name}"):
        return [str(prim.GetPath())]
    if is_per_instance(name):
        return instance_names(prim)
    return [str(each.GetPath()) for each in ([prim] if prim.HasAttribute(name) else prototypes(prim))]


def apply_or_schedule(name: str, value: Any, prims: Sequence[Usd.Prim]) -> None:
    """Write constants (one for all, or a list of one per prim) immediately, distributions at every firing."""
    if isinstance(value, Distribution):
        attribute(name, value, input_prims=list(prims))
        return
    for prim, one in zip(prims, _per_prim(name, value, prims)):
        set_attribute(prim, name, one)


def _per_prim(name: str, value: Any, prims: Sequence[Usd.Prim], type_name: str | None = None) -> list[Any]:
    if not isinstance(value, list) or len(value) != len(prims):
        return [value] * len(prims)
    owners = owners_of(prims[0], name) if is_vector(value) else []
    # A list of numbers is one value for all prims if the attribute is a vector of that size or an array.
    targets = [attribute_of(owner, name, type_name) for owner in owners[:1]]
    one_for_all = any(len(value) == dimension(each) or each.GetTypeName().isArray for each in targets)
    return [value] * len(prims) if one_for_all else value
