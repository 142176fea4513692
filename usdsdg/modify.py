"""Changes to existing prims, drawn again at each firing. Mirrors `rep.modify`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdShade

from usdsdg.distribution import Distribution, draw, is_vector
from usdsdg.errors import BadPrim, GraphError
from usdsdg.graph.evaluate import act, act_now
from usdsdg.graph.kinds import action
from usdsdg.graph.node import Node, ReplicatorItem, plain, prim_paths
from usdsdg.registry import near_misses
from usdsdg.stage import semantics as labels
from usdsdg.stage import transforms
from usdsdg.stage.context import current_stage
from usdsdg.values import labels_per_prim, shown, vector


def prim_at(path: str) -> Usd.Prim:
    """The prim at `path` of the current stage.

    Raises:
        BadPrim: there is none.
    """
    prim = current_stage().GetPrimAtPath(path)
    if not prim:
        raise BadPrim(f"{path} is not on the stage (was it removed after the graph was built?)")
    return prim


def non_xform_prims(prim: Usd.Prim) -> list[Usd.Prim]:
    """Where an object's attributes live: the prim itself, or the children of an object Xform."""
    if prim.GetTypeName() != "Xform" or not prim.HasAttribute("replicatorXform"):
        return [prim]
    return [child for child in prim.GetChildren() if child.GetTypeName() != "Scope"]


def _attribute(prim: Usd.Prim, name: str, attribute_type: str | None) -> Usd.Attribute:
    for candidate in (name, f"inputs:{name}"):
        if prim.HasAttribute(candidate):
            return prim.GetAttribute(candidate)
    if attribute_type is None:
        near = near_misses(name, [a.GetName() for a in prim.GetAttributes()])
        raise GraphError(
            f"{prim.GetPath()} has no attribute {name!r}"
            + (f"; similar: {', '.join(near[:5])}" if near else "")
            + ". Pass attribute_type to create it."
        )
    type_name = Sdf.ValueTypeNames.Find(attribute_type)
    if not type_name:
        raise GraphError(f"attribute_type={attribute_type!r} is not a USD value type such as 'float' or 'color3f'")
    return prim.CreateAttribute(name, type_name, custom=True)


def _as_usd(value: Any, attribute: Usd.Attribute) -> Any:
    """A drawn value in the attribute's own type; a scalar fills all components of a vector."""
    default = attribute.GetTypeName().defaultValue
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(default, Sdf.AssetPath):
        return Sdf.AssetPath(str(value))
    if size := _dimension(attribute):
        return type(default)(*vector(attribute.GetName().removeprefix("inputs:"), value, size))
    if isinstance(default, bool):
        return bool(value)
    if isinstance(default, int):
        return math.floor(value)
    return value


def _dimension(attribute: Usd.Attribute) -> int:
    """Numbers in one value of a vector attribute; 0 for every other type."""
    size = getattr(type(attribute.GetTypeName().defaultValue), "dimension", 0)
    return size if isinstance(size, int) else 0


def set_attribute(prim: Usd.Prim, name: str, value: Any, attribute_type: str | None = None) -> None:
    """Author one value on the prim that has the attribute (the prim itself, else the object's children)."""
    owners = [prim] if prim.HasAttribute(name) or prim.HasAttribute(f"inputs:{name}") else non_xform_prims(prim)
    for owner in owners:
        target = _attribute(owner, name, attribute_type)
        if not _set(target, _as_usd(value, target)):
            raise GraphError(f"{target.GetPath()} is a {target.GetTypeName()}; it does not take {shown(value)}")


def _set(attribute: Usd.Attribute, value: Any) -> bool:
    try:
        return attribute.Set(value)
    except (Tf.ErrorException, TypeError):  # a value of a type that USD does not convert
        return False


def attribute(name: str, value: Any, attribute_type: str | None = None, input_prims: Any = None) -> ReplicatorItem:
    """Write `value` (constant, one per prim, or a distribution) to attribute `name`, or `inputs:<name>`."""
    return act("OgnWritePrimAttribute", input_prims, attribute=name, value=value, attributeType=attribute_type)


@action("OgnWritePrimAttribute")
def _write_attribute(node: Node, execution: int) -> None:
    for path, drawn in zip(node.prims, draw(node.inputs["value"], node, execution, "value")):
        set_attribute(prim_at(path), node.inputs["attribute"], drawn, node.inputs.get("attributeType"))


def apply_or_schedule(name: str, value: Any, prims: Sequence[Usd.Prim]) -> None:
    """Write constants (one for all, or a list of one per prim) now, and distributions whenever the trigger fires."""
    if isinstance(value, Distribution):
        attribute(name, value, input_prims=list(prims))
        return
    for prim, one in zip(prims, _per_prim(name, value, prims)):
        set_attribute(prim, name, one)


def _per_prim(name: str, value: Any, prims: Sequence[Usd.Prim]) -> list[Any]:
    if not isinstance(value, list) or len(value) != len(prims):
        return [value] * len(prims)
    # Three numbers are one colour, also for three prims.
    one_for_all = is_vector(value) and len(value) == _dimension(_attribute(prims[0], name, None))
    return [value] * len(prims) if one_for_all else value


# --- pose ---


def pose(
    position: Any = None, position_x: Any = None, position_y: Any = None, position_z: Any = None, rotation: Any = None,
    rotation_x: Any = None, rotation_y: Any = None, rotation_z: Any = None, rotation_order: str = "XYZ",
    scale: Any = None, size: Any = None, pivot: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    input_prims: Any = None, name: str | None = None,
) -> ReplicatorItem:  # fmt: skip
    """Set position, then rotation [degrees], then scale, then look-at.

    Raises:
        ValueError: arguments that exclude each other, or are not available yet.
    """
    per_axis = [position_x, position_y, position_z, rotation_x, rotation_y, rotation_z, size, pivot]
    if any(value is not None for value in per_axis) or rotation_order != "XYZ":
        raise GraphError(
            "modify.pose: per-axis arguments, size, pivot and rotation_order are not available yet; "
            "use position, rotation, scale, look_at."
        )
    if rotation is not None and look_at is not None:
        raise GraphError("modify.pose: give rotation or look_at, not both")
    values = dict(position=position, rotation=rotation, scale=scale, look_at=look_at, look_at_up_axis=look_at_up_axis)
    given = {role: value for role, value in values.items() if value is not None}
    return act("OgnWritePose", input_prims, name=name, attribute=",".join(given), **given)


def apply_or_schedule_pose(item: ReplicatorItem, **pose_values: Any) -> None:
    """Constants now; distributions at every firing."""
    given = {role: value for role, value in pose_values.items() if value is not None}
    later = {role: value for role, value in given.items() if isinstance(value, Distribution)}
    now = {role: value for role, value in given.items() if role not in later}
    if now:
        _write_pose(Node(kind="OgnWritePose", inputs={r: plain(v) for r, v in now.items()}, prims=item.prims), 0)
    if later:
        pose(**later, input_prims=item)


@action("OgnWritePose")
def _write_pose(node: Node, execution: int) -> None:
    drawn = {role: draw(value, node, execution, role) for role, value in node.inputs.items() if role != "attribute"}
    for index, path in enumerate(node.prims):
        prim = prim_at(path)
        values = {role: column[index] for role, column in drawn.items()}
        parts: dict[str, Any] = {}
        if "position" in values:
            parts["translate"] = Gf.Vec3d(vector("position", values["position"]))
        if "rotation" in values:
            parts["rotate_xyz"] = Gf.Vec3d(vector("rotation", values["rotation"]))
        if "scale" in values:
            parts["scale"] = Gf.Vec3d(vector("scale", values["scale"]))
        transforms.author_pose(prim, **parts)
        if "look_at" in values:
            _look_at(prim, values["look_at"], values.get("look_at_up_axis"))


def _look_at(prim: Usd.Prim, target: Any, up: Any) -> None:
    """Turn the prim so that its camera child (or its own -Z) looks at a point or a prim."""
    is_point = not isinstance(target, (str, Sdf.Path, Usd.Prim, ReplicatorItem))
    if is_point:
        point = Gf.Vec3d(vector("look_at", target))
    else:
        point = transforms.local_to_world(prim_at(prim_paths(target)[0])).ExtractTranslation()
    default_up = (0, 0, 1) if transforms.up_axis(current_stage()) == "Z" else (0, 1, 0)
    eye = transforms.local_to_world(prim).ExtractTranslation()
    to_world = transforms.look_at(eye, point, up=vector("look_at_up_axis", up) if up is not None else default_up)
    # The child camera of a Replicator camera object is turned against the object; undo that turn.
    cameras = [child for child in prim.GetChildren() if child.IsA(UsdGeom.Camera)]
    if cameras:
        to_world = UsdGeom.Xformable(cameras[0]).GetLocalTransformation().GetInverse() * to_world
    parent = prim.GetParent()
    parent_to_world = transforms.local_to_world(parent) if parent.IsA(UsdGeom.Imageable) else Gf.Matrix4d(1)
    local = to_world * parent_to_world.GetInverse()
    euler = Gf.Rotation(local.ExtractRotationQuat()).Decompose(Gf.Vec3d(0, 0, 1), Gf.Vec3d(0, 1, 0), Gf.Vec3d(1, 0, 0))
    transforms.author_pose(prim, rotate_xyz=Gf.Vec3d(euler[2], euler[1], euler[0]))


# --- semantics, visibility, material, variant ---


def semantics(semantics: Any = None, input_prims: Any = None, mode: str = "add") -> ReplicatorItem:
    """Label prims; `mode` is add, replace or clear. Written when this line runs, as labels are no random matter.

    `semantics` is a list of (type, label) pairs or a mapping of type to label or labels, or a list of one of these per
    prim.

    Raises:
        GraphError: it is something else, or the mode does not exist.
    """
    if mode not in ("add", "replace", "clear"):
        raise GraphError(f"modify.semantics: mode={mode!r}; known: add, replace, clear")
    return act_now("OgnWriteSemantics", input_prims, semantics=semantics, mode=mode)


@action("OgnWriteSemantics")
def _write_semantics(node: Node, execution: int) -> None:
    per_prim = labels_per_prim(node.inputs.get("semantics") or {}, len(node.prims))
    for path, given in zip(node.prims, per_prim):
        labels.add_labels(prim_at(path), given, mode=node.inputs["mode"])


def visibility(value: Any = None, input_prims: Any = None, name: str | None = None) -> ReplicatorItem:
    """Show or hide prims; None draws yes or no for each."""
    from usdsdg.distribution import choice

    chosen = choice([True, False]) if value is None else value
    if isinstance(chosen, Distribution):
        return act("OgnWriteVisibility", input_prims, name=name, value=chosen)
    return act_now("OgnWriteVisibility", input_prims, value=chosen)


@action("OgnWriteVisibility")
def _write_visibility(node: Node, execution: int) -> None:
    for path, visible in zip(node.prims, draw(node.inputs["value"], node, execution, "value")):
        imageable = UsdGeom.Imageable(prim_at(path))
        (imageable.MakeVisible if visible else imageable.MakeInvisible)()


def material(value: Any, input_prims: Any = None, name: str | None = None) -> ReplicatorItem:
    """Bind a material (a path, prim, item, or a distribution over these), stronger than what is bound below."""
    if isinstance(value, Distribution):
        return act("OgnWriteMaterial", input_prims, name=name, value=value)
    return act_now("OgnWriteMaterial", input_prims, value=value)


@action("OgnWriteMaterial")
def _write_material(node: Node, execution: int) -> None:
    for path, chosen in zip(node.prims, draw(node.inputs["value"], node, execution, "value")):
        bind_material(prim_at(path), prim_at(prim_paths(chosen)[0]))


def bind_material(prim: Usd.Prim, bound: Usd.Prim) -> None:
    """Bind so that it wins over bindings of descendants, as the randomizers need."""
    binding = UsdShade.MaterialBindingAPI.Apply(prim)
    binding.Bind(UsdShade.Material(bound), UsdShade.Tokens.strongerThanDescendants)


def variant(name: str, value: Any, input_prims: Any = None) -> ReplicatorItem:
    """Select a variant of variant set `name`."""
    return act("OgnWriteVariant", input_prims, attribute=name, value=value)


@action("OgnWriteVariant")
def _write_variant(node: Node, execution: int) -> None:
    name = node.inputs["attribute"]
    for path, chosen in zip(node.prims, draw(node.inputs["value"], node, execution, "value")):
        variants = prim_at(path).GetVariantSets()
        if name not in variants.GetNames():
            raise GraphError(f"{path} has no variant set {name!r}; it has: {', '.join(variants.GetNames()) or 'none'}")
        known = variants.GetVariantSet(name).GetVariantNames()
        if chosen not in known:
            raise GraphError(f"{path}: variant set {name!r} has no {chosen!r}; it has: {', '.join(known)}")
        variants.GetVariantSet(name).SetVariantSelection(chosen)
