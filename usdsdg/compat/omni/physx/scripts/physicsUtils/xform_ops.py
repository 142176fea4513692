"""Transform ops of prims as physics wants them: translate, orient and scale."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

from pxr import Gf, Sdf, Usd, UsdGeom

_KINDS: dict[str, tuple[Any, Callable[[Any], Any]]] = {
    "translate": (UsdGeom.XformOp.TypeTranslate, Gf.Vec3f),
    "orient": (UsdGeom.XformOp.TypeOrient, Gf.Quatf),
    "scale": (UsdGeom.XformOp.TypeScale, Gf.Vec3f),
}

Vector: TypeAlias = Gf.Vec3f | Gf.Vec3d | Gf.Vec3h
Quaternion: TypeAlias = Gf.Quatf | Gf.Quatd | Gf.Quath


def set_or_add_translate_op(xformable: UsdGeom.Xformable, translate: Vector) -> UsdGeom.XformOp:
    """Set the op translate, in the precision that it has; one that is added is in single precision."""
    return _set_or_add(xformable, "translate", translate)


def set_or_add_orient_op(xformable: UsdGeom.Xformable, orient: Quaternion) -> UsdGeom.XformOp:
    """Set the op orient; see `set_or_add_translate_op`."""
    return _set_or_add(xformable, "orient", orient)


def set_or_add_scale_op(xformable: UsdGeom.Xformable, scale: Vector) -> UsdGeom.XformOp:
    """Set the op scale; see `set_or_add_translate_op`."""
    return _set_or_add(xformable, "scale", scale)


def set_or_add_scale_orient_translate(
    xformable: UsdGeom.Xformable, scale: Vector, orient: Quaternion, translate: Vector
) -> list[UsdGeom.XformOp]:
    """Set all three; return translate, orient and scale."""
    return [
        set_or_add_translate_op(xformable, translate),
        set_or_add_orient_op(xformable, orient),
        set_or_add_scale_op(xformable, scale),
    ]


def setup_transform_as_scale_orient_translate(xformable: UsdGeom.Xformable) -> None:
    """Give a prim the ops translate, orient and scale alone, at the same transform; shear is lost."""
    copy_transform_as_scale_orient_translate(xformable, xformable)


def copy_transform_as_scale_orient_translate(src: UsdGeom.Xformable, dst: UsdGeom.Xformable) -> None:
    """Give `dst` the local transform of `src` as the ops translate, orient and scale alone; shear is lost."""
    source, target = UsdGeom.Xformable(src), UsdGeom.Xformable(dst)
    is_reset, placed = source.GetResetXformStack(), Gf.Transform(source.GetLocalTransformation())
    with Sdf.ChangeBlock():
        turn = Gf.Quatd(placed.GetRotation().GetQuat())
        ops = set_or_add_scale_orient_translate(target, placed.GetScale(), turn, placed.GetTranslation())
        target.SetXformOpOrder(ops, is_reset)


def get_translation(prim: Usd.Prim) -> Vector:
    """Return the value of the op translate."""
    return prim.GetAttribute("xformOp:translate").Get()


def place(xformable: UsdGeom.Xformable, position: Vector, orientation: Quaternion, scale: Vector) -> None:
    """Add the ops translate, orient and scale to a prim that has none."""
    xformable.AddTranslateOp().Set(position)
    xformable.AddOrientOp().Set(orientation)
    xformable.AddScaleOp().Set(scale)


def _set_or_add(prim: UsdGeom.Xformable | Usd.Prim, name: str, value: Any) -> UsdGeom.XformOp:
    xformable, (kind, made) = UsdGeom.Xformable(prim), _KINDS[name]
    op = UsdGeom.XformOp(xformable.GetPrim().GetAttribute(f"xformOp:{name}"))
    if not op:
        op = xformable.AddXformOp(kind, UsdGeom.XformOp.PrecisionFloat)
    before = op.Get()
    op.Set(made(value) if before is None else type(before)(value))
    return op
