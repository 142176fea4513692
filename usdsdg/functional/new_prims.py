"""Definition of new prims: paths, xform ops, and the arguments that all `create` functions share."""

import collections
from collections.abc import Sequence
from typing import Any

from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from usdsdg.arguments.prim_names import prim_name
from usdsdg.arguments.prims import one_prim
from usdsdg.arguments.values import count_of, labels_per_prim, shown
from usdsdg.errors import ArgumentError, counted
from usdsdg.functional import modify
from usdsdg.functional.arguments import per_prim
from usdsdg.functional.poses import set_poses
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.paths import check_parent
from usdsdg.stage.semantics.labels import add_labels

_OPS = (
    ("translate", Sdf.ValueTypeNames.Double3, Gf.Vec3d(0)),
    ("orient", Sdf.ValueTypeNames.Quatd, Gf.Quatd(1)),
    ("scale", Sdf.ValueTypeNames.Double3, Gf.Vec3d(1)),
)


def new_paths(name: str, parent: Any, count: Any) -> list[str]:
    """Return `count` free paths `<parent>/<name>`, `<name>_01`, ... under one parent, or under one parent each.

    Raises:
        BadPrim: a parent is not on the stage, or is a shape (USD does not nest shapes).
        ArgumentError: count is not an integer, or there is another number of parents.
    """
    count = count_of(count)
    if not isinstance(parent, (list, tuple)):
        return _free_paths(_parent_path(parent), prim_name(name), count)
    if len(parent) != count:
        raise ArgumentError(f"parent has {counted(len(parent), 'prim')} for count {count}; give one, or one for each")
    parents = [_parent_path(each) for each in parent]
    free = {
        each: iter(_free_paths(each, prim_name(name), number)) for each, number in collections.Counter(parents).items()
    }
    return [next(free[each]) for each in parents]


def define(paths: Sequence[str], type_name: str, *, with_ops: bool = True) -> list[Usd.Prim]:
    """Define prims in the current edit target, by default with translate, orient and scale ops."""
    stage = current_stage()
    target = stage.GetEditTarget()
    with Sdf.ChangeBlock():
        for path in paths:
            spec = Sdf.CreatePrimInLayer(target.GetLayer(), target.MapToSpecPath(Sdf.Path(path)))
            spec.specifier = Sdf.SpecifierDef
            if type_name:
                spec.typeName = type_name
            if with_ops:
                _author_ops(spec)
    return [stage.GetPrimAtPath(path) for path in paths]


def add_missing_ops(prims: Sequence[Usd.Prim]) -> None:
    """Add translate, orient and scale ops to prims that have no transform of their own."""
    for prim in prims:
        xformable = UsdGeom.Xformable(prim)
        if xformable and not xformable.GetXformOpOrderAttr().HasAuthoredValue():
            target = prim.GetStage().GetEditTarget()
            _author_ops(Sdf.CreatePrimInLayer(target.GetLayer(), target.MapToSpecPath(prim.GetPath())))


def apply_common_arguments(
    prims: list[Usd.Prim],
    *,
    semantics: Any = None,
    visible: Any = True,
    material: Any = None,
    pivot: Any = None,
    relative_to: Any = None,
    position: Any = None,
    rotation: Any = None,
    scale: Any = None,
    **pose: Any,
) -> list[Usd.Prim]:
    """Write labels, visibility, material and pose of new prims; return the prims."""
    if semantics is not None:
        for prim, labels in zip(prims, labels_per_prim(semantics, len(prims))):
            add_labels(prim, labels)
    if visible is not True:
        modify.visibility(prims, visible)
    if material is not None:
        modify.material(prims, material)
    if relative_to is not None:
        # Parts that are not given are the identity relative to the other prim, not relative to the parent.
        position = (0.0, 0.0, 0.0) if position is None else position
        scale = 1.0 if scale is None else scale
        if pose.get("look_at") is None:
            rotation = (0.0, 0.0, 0.0) if rotation is None else rotation
    if pivot is not None and position is None:
        position = (0.0, 0.0, 0.0)
    set_poses(prims, position=position, rotation=rotation, scale=scale, pivot=pivot, relative_to=relative_to, **pose)
    return prims


def numbers(name: str, value: Any, count: int) -> list[float] | None:
    """Return one number per prim; None for None.

    Raises:
        ArgumentError: a value is not a number.
    """
    if value is None:
        return None
    try:
        return [float(each) for each in per_prim(value, count)]
    except (TypeError, ValueError):
        raise ArgumentError(f"{name} is {shown(value)}; expected a number, or a list with one per prim") from None


def _author_ops(spec: Sdf.PrimSpec) -> None:
    for op, type_name, value in _OPS:
        Sdf.AttributeSpec(spec, f"xformOp:{op}", type_name).default = value
    order = Sdf.AttributeSpec(spec, "xformOpOrder", Sdf.ValueTypeNames.TokenArray, Sdf.VariabilityUniform)
    order.default = Vt.TokenArray([f"xformOp:{op}" for op, _, _ in _OPS])


def _parent_path(parent: Any) -> Sdf.Path:
    if parent is None or str(parent) == "/":
        return Sdf.Path.absoluteRootPath
    prim = one_prim("parent", parent)
    check_parent(prim)
    return prim.GetPath()


def _free_paths(parent: Sdf.Path, name: str, count: int) -> list[str]:
    names = set(current_stage().GetPrimAtPath(parent).GetAllChildrenNames())
    found: list[str] = []
    number = 0
    while len(found) < count:
        candidate = f"{name}_{number:02d}" if number else name
        if candidate not in names:
            found.append(str(parent.AppendChild(candidate)))
        number += 1
    return found
