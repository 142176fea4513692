"""Changes to existing prims that act when the line runs. Mirrors `rep.functional.modify`.

Every function takes one prim or a list of prims (also paths), and values once for all prims or as a list or array with
one per prim. Nothing is returned.
"""

from typing import Any

from pxr import Sdf, Usd, UsdGeom, UsdShade

from usdsdg.arguments.prims import one_prim, prims_of
from usdsdg.arguments.values import labels_per_prim, shown
from usdsdg.errors import ArgumentError, BadPrim, warn_once
from usdsdg.functional.arguments import per_prim
from usdsdg.functional.poses import set_instancer_poses, set_poses
from usdsdg.stage import materials
from usdsdg.stage.attributes import attribute_of, set_value
from usdsdg.stage.semantics.labels import add_labels

__all__ = [
    "attribute", "look_at", "material", "pose", "position", "rotation", "scale", "semantics", "variant", "visibility",
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
    """Set the parts of the poses that are given, in the ops that the prims have.

    Args:
        prims: N prims of one stage. A PointInstancer takes one value per instance instead.
        position_value: (3,) or (N, 3) in the space of each prim's parent [stage units].
        rotation_value: Euler angles in degrees, (3,) or (N, 3); quaternions x, y, z, w, (4,) or (N, 4); Gf.Rotation or
            Gf quaternions.
        rotation_order: Angle i turns about axis i of it, the first axis first. Default: the setting
            /app/primCreation/DefaultRotationOrder, else "XYZ".
        scale_value: One factor, one vector (3,), or one of these per prim.
        relative_to: Prim or path, or one per prim; the parts that are given are then in the space of that prim.
        look_at_value: World point or prim that -Z of each prim shall point at, or one per prim.
        look_at_up_axis: World direction of +Y as far as possible; None is the stage's up axis.
        pivot: Point of the prim's bounding box, -1 to 1 per axis. It comes to lie at the position given, or stays
            where it is while the prim is turned and scaled about it.
        write_to_usd: There is no other place to write to: poses go to the stage whatever is given here.

    Raises:
        BadPrim: a prim has no transform, lies inside an instance, or does not exist any more.
        DegenerateFrame: a prim shall look at its own position.
        ArgumentError: a value has another shape, or rotation and look-at are both given.
        Unsupported: look_at, pivot or relative_to for a PointInstancer.
    """
    targets = prims_of(prims)
    values = (position_value, rotation_value, rotation_order, scale_value)
    others: dict[str, Any] = {"relative_to": relative_to, "look_at": look_at_value, "pivot": pivot}
    instancers = _instancers(targets)
    if instancers and len(targets) > 1:
        raise ArgumentError(
            f"{instancers[0].GetPath()} is a PointInstancer, which takes one value per instance; pose it in a call of "
            "its own"
        )
    if instancers:
        set_instancer_poses(instancers[0], *values, **others)
        return
    set_poses(
        targets, position=position_value, rotation=rotation_value, rotation_order=rotation_order, scale=scale_value,
        look_at_up_axis=look_at_up_axis, **others,
    )  # fmt: skip


# The prims of the last call, when none of them was a PointInstancer: asking a thousand takes most of a millisecond.
_ordinary: list[Usd.Prim] = []


def _instancers(prims: list[Usd.Prim]) -> list[Usd.Prim]:
    global _ordinary
    if prims == _ordinary:
        return []
    found = [prim for prim in prims if prim.IsA(UsdGeom.PointInstancer)]
    _ordinary = [] if found else prims
    return found


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
    """Turn prims so that their -Z points at `value`; see `pose` for the arguments."""
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
    """Label prims.

    Args:
        value: {"class": "cube" or ["cube", ...]}, a list of (type, label) pairs, or a list with one of these per prim.
        mode: "add" to the labels there are, "replace" those of the types given, or "clear" all before.

    Raises:
        ArgumentError: the value or the mode is none of these.
    """
    if str(mode).lower() not in ("add", "replace", "clear"):
        raise ArgumentError(f"mode is {mode!r}; expected 'add', 'replace' or 'clear'")
    targets = prims_of(prims)
    if isinstance(value, (list, tuple)) and len(value) == 2 and all(isinstance(each, str) for each in value):
        value = [tuple(value)]
    for prim, labels in zip(targets, labels_per_prim({} if value is None else value, len(targets))):
        add_labels(prim, labels, mode=str(mode).lower())


def visibility(prims: Any, value: Any) -> None:
    """Show (True: as the parent is) or hide (False) prims. Prims that are not Imageable are left out, with a warning.

    Raises:
        ArgumentError: a value is no bool.
    """
    targets = prims_of(prims)
    shows = per_prim(value, len(targets))
    if not all(isinstance(show, bool) for show in shows):
        raise ArgumentError(f"visibility is {shown(value)}; expected True or False, or a list with one per prim")
    for prim, show in zip(targets, shows):
        if not prim.IsA(UsdGeom.Imageable):
            warn_once(f"{prim.GetPath()} ({prim.GetTypeName() or 'no type'}) has no visibility and is left as it is")
            continue
        tokens = UsdGeom.Tokens
        UsdGeom.Imageable(prim).CreateVisibilityAttr().Set(tokens.inherited if show else tokens.invisible)


def material(prims: Any, material_prim: Any) -> None:
    """Bind a material, or one per prim.

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
    """Select a variant of variant set `name`, or one per prim.

    Raises:
        BadPrim: a prim has no such variant set, or the set no such variant.
    """
    targets = prims_of(prims)
    for prim, chosen in zip(targets, per_prim(value, len(targets))):
        sets = prim.GetVariantSets()
        if name not in sets.GetNames():
            raise BadPrim(
                f"{prim.GetPath()} has no variant set {name!r}; it has {', '.join(sets.GetNames()) or 'none'}"
            )
        known = sets.GetVariantSet(name).GetVariantNames()
        if chosen not in known:
            raise BadPrim(f"{prim.GetPath()}: variant set {name!r} has no {chosen!r}; it has {', '.join(known)}")
        sets.GetVariantSet(name).SetVariantSelection(chosen)
