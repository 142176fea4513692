"""Immediate changes to existing prims: `rep.functional.modify`.

Every function takes a prim, a path or a list of these, and values once for all prims or as a list or array with one per
prim. Nothing is returned.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from pxr import Sdf, Usd, UsdGeom, UsdShade

from usdsdg.arguments.parameters import name_parameters
from usdsdg.arguments.prims import one_prim, prims_of
from usdsdg.arguments.values import labels_per_prim, shown
from usdsdg.errors import ArgumentError, BadPrim, warn_once
from usdsdg.functional.arguments import per_prim
from usdsdg.functional.poses import set_instancer_poses, set_mixed_poses, set_poses
from usdsdg.stage import materials
from usdsdg.stage.attributes import attribute_of, set_value
from usdsdg.stage.keypoints import set_keypoints
from usdsdg.stage.prims.variants import select_variant
from usdsdg.stage.semantics.labels import add_labels

__all__ = [
    "attribute", "keypoints", "look_at", "material", "pose", "position", "rotation", "scale", "semantics", "variant",
    "visibility",
]  # fmt: skip


def pose(
    prims: Any,
    position_value: Any = None,
    rotation_value: Any = None,
    rotation_order: str | None = None,
    scale_value: Any = None,
    relative_to: Any = None,
    look_at_value: Any = None,
    look_at_up_axis: Any = (0, 1, 0),
    pivot: Any = None,
    *,
    write_to_usd: bool | None = None,
) -> None:
    """Set the given parts of the poses, in the existing xform ops of the prims.

    Args:
        prims: N prims of one stage. A PointInstancer takes one value per instance instead, also among other prims.
        position_value: (3,) or (N, 3) in the space of each prim's parent [stage units].
        rotation_value: Euler angles [degrees], (3,) or (N, 3); quaternions x, y, z, w, (4,) or (N, 4); Gf.Rotation or
            Gf quaternions.
        rotation_order: angle i rotates about axis i of it, the first axis first. Default: the setting
            /app/primCreation/DefaultRotationOrder, else "XYZ".
        scale_value: one factor, one vector (3,), or one of these per prim.
        relative_to: prim or path, or one per prim; the given parts are then in the space of that prim.
        look_at_value: world point or prim that -Z of each prim points at, or one per prim.
        look_at_up_axis: world direction of +Y as far as possible, or "X", "Y" or "Z"; None is the stage's up axis.
        pivot: point of the prim's bounding box, -1 to 1 per axis. It is placed at the given position, or, without a
            position, keeps its place while the prim is rotated and scaled about it.
        write_to_usd: ignored: poses are always written to the stage.

    Raises:
        BadPrim: a prim has no transform, lies inside an instance, or does not exist any more.
        DegenerateFrame: the target of a prim is its own position.
        ArgumentError: a value has another shape, or rotation and look-at are both given.
        Unsupported: look_at, pivot or relative_to for a PointInstancer.
    """
    targets = prims_of(prims)
    values = (position_value, rotation_value, rotation_order, scale_value)
    others: dict[str, Any] = {"relative_to": relative_to, "look_at": look_at_value, "pivot": pivot}
    instancers = _instancers(targets)
    if instancers and len(targets) > 1:
        given = dict(position=position_value, rotation=rotation_value, scale=scale_value)
        set_mixed_poses(targets, instancers, given, rotation_order=rotation_order, **others)
        return
    if instancers:
        set_instancer_poses(instancers[0], *values, **others)
        return
    set_poses(
        targets, position=position_value, rotation=rotation_value, rotation_order=rotation_order, scale=scale_value,
        look_at_up_axis=look_at_up_axis, **others,
    )  # fmt: skip


def _instancers(prims: list[Usd.Prim]) -> list[Usd.Prim]:
    # One prim of each type is tested: testing a thousand takes most of a millisecond.
    of_each_type = dict(zip(map(Usd.Prim.GetTypeName, prims), prims))
    if not any(prim.IsA(UsdGeom.PointInstancer) for prim in of_each_type.values()):
        return []
    return [prim for prim in prims if prim.IsA(UsdGeom.PointInstancer)]


def position(
    prims: Any, value: Any, relative_to: Any = None, pivot: Any = None, *, write_to_usd: bool | None = None
) -> None:
    """Set positions; see `pose` for the arguments."""
    pose(prims, position_value=value, relative_to=relative_to, pivot=pivot, write_to_usd=write_to_usd)


def rotation(
    prims: Any, value: Any, value_rotation_order: str = "XYZ", relative_to: Any = None, pivot: Any = None, *,
    write_to_usd: bool | None = None,
) -> None:  # fmt: skip
    """Set rotations; see `pose` for the arguments."""
    pose(
        prims, rotation_value=value, rotation_order=value_rotation_order, relative_to=relative_to, pivot=pivot,
        write_to_usd=write_to_usd,
    )  # fmt: skip


def scale(prims: Any, value: Any, *, relative_to: Any = None, write_to_usd: bool | None = None) -> None:
    """Set scales; see `pose` for the arguments."""
    pose(prims, scale_value=value, relative_to=relative_to, write_to_usd=write_to_usd)


def look_at(prims: Any, value: Any, look_at_up_axis: Any = (0, 1, 0), *, write_to_usd: bool | None = None) -> None:
    """Rotate prims so that their -Z points at `value`; see `pose` for the arguments."""
    pose(prims, look_at_value=value, look_at_up_axis=look_at_up_axis, write_to_usd=write_to_usd)


def attribute(prims: Any, attribute_name: str, value: Any) -> None:
    """Set an attribute, `<name>` or `inputs:<name>`, to one value or to one per prim.

    For a single prim a list is the value itself. For materials and MDL shaders the name is that of an input of the
    material, which is added if it has no value yet. Strings for asset attributes are files or URLs below the assets
    root.

    Raises:
        AssetNotFound: there is no such file.
        BadPrim: a prim has no such attribute, or its material no such input.
        BadValue: the attribute does not take the value.
    """
    targets = prims_of(prims)
    # A list for one prim given by itself is the value; [prim] with [value] is one value per prim.
    values = per_prim(value, len(targets)) if isinstance(prims, (list, tuple)) else [value] * len(targets)
    plain = []
    for prim, each in zip(targets, values):
        if materials.is_mdl(prim) and (attribute_name.startswith("inputs:") or not prim.HasAttribute(attribute_name)):
            materials.set_input(prim, attribute_name.removeprefix("inputs:"), each)
        else:
            plain.append((attribute_of(prim, attribute_name), each))
    with Sdf.ChangeBlock():
        for target, each in plain:
            set_value(target, each)


def semantics(prims: Any, value: Any = None, mode: str = "add") -> None:
    """Set semantic labels of prims.

    Args:
        value: {"class": "cube" or ["cube", ...]}, a list of (type, label) pairs, one pair, "class:cube;color:red", or a
            list with one of these per prim or one for all.
        mode: "add" to the existing labels, "replace" those of the given types, or "clear" all labels first.

    Raises:
        ArgumentError: the value or the mode is none of these.
    """
    lowered = str(mode).lower()
    if lowered not in ("add", "replace", "clear"):
        raise ArgumentError(f"mode is {mode!r}; expected 'add', 'replace' or 'clear'")
    targets = prims_of(prims)
    is_pair = isinstance(value, list) and len(value) == 2 and all(isinstance(each, str) for each in value)
    if is_pair and not all(":" in each for each in value):
        value = tuple(value)
    for prim, labels in zip(targets, labels_per_prim({} if value is None else value, len(targets))):
        add_labels(prim, labels, mode=lowered)


def keypoints(prims: Any, value: Mapping[str, Sequence[float]], mode: str = "add") -> None:
    """Set named points of prims, which the annotator `keypoints` projects; beyond Replicator.

    Args:
        value: {"left_eye": (x, y, z), ...} in the frame of each prim [stage units].
        mode: "add" to the existing points, replacing those of the same names, or "replace" all of them.

    Raises:
        ArgumentError: the value or the mode is none of these.
        BadPrim: a prim lies inside an instance.
    """
    if mode not in ("add", "replace"):
        raise ArgumentError(f"mode is {mode!r}; expected 'add' or 'replace'")
    if not isinstance(value, Mapping):
        raise ArgumentError(f"keypoints are {shown(value)}; expected {{'name': (x, y, z)}}")
    for prim in prims_of(prims):
        try:
            set_keypoints(prim, value, replace=mode == "replace")
        except ValueError as error:
            raise ArgumentError(f"{prim.GetPath()}: {error}") from None


def visibility(prims: Any, value: Any) -> None:
    """Show (True: inherit the parent's visibility) or hide (False) prims; skip prims that are not Imageable, warning.

    Raises:
        ArgumentError: a value is not a bool.
    """
    targets = prims_of(prims)
    visible = per_prim(value, len(targets))
    if not all(isinstance(each, bool) for each in visible):
        raise ArgumentError(f"visibility is {shown(value)}; expected True or False, or a list with one per prim")
    for prim, each in zip(targets, visible):
        if not prim.IsA(UsdGeom.Imageable):
            warn_once(f"{prim.GetPath()} ({prim.GetTypeName() or 'no type'}) has no visibility and is left unchanged")
            continue
        tokens = UsdGeom.Tokens
        UsdGeom.Imageable(prim).CreateVisibilityAttr().Set(tokens.inherited if each else tokens.invisible)


def material(prims: Any, material_prim: Any) -> None:
    """Bind a material to all prims, or one to each.

    Raises:
        BadPrim: it is not a Material.
    """
    targets = prims_of(prims)
    chosen = [one_prim("material_prim", each) for each in per_prim(material_prim, len(targets))]
    for prim, bound in zip(targets, chosen):
        if not bound.IsA(UsdShade.Material):
            raise BadPrim(f"{bound.GetPath()} is a {bound.GetTypeName() or 'prim without a type'}, not a Material")
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(UsdShade.Material(bound))


def variant(prims: Any, name: str, value: Any) -> None:
    """Select a variant of the variant set `name`, one for all prims or one for each.

    Raises:
        BadPrim: a prim has no such variant set, or the set no such variant.
    """
    targets = prims_of(prims)
    for prim, chosen in zip(targets, per_prim(value, len(targets))):
        select_variant(prim, name, chosen)


name_parameters(globals())
