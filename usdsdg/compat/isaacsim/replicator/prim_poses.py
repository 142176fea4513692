"""Poses of prims through their xform ops, for the behaviors and for grasping."""

from __future__ import annotations

from pxr import Gf, Usd, UsdGeom

_ORIENT_PRECISION = {Gf.Quatf: UsdGeom.XformOp.PrecisionFloat, Gf.Quatd: UsdGeom.XformOp.PrecisionDouble}


def set_location(prim: Usd.Prim, location: Gf.Vec3d) -> None:
    """Set the first translation of a prim, appended to its ops if it has none."""
    _first(prim, UsdGeom.XformOp.TypeTranslate, lambda xform: xform.AddTranslateOp()).Set(location)


def set_orientation(prim: Usd.Prim, orientation: Gf.Quatf | Gf.Quatd) -> None:
    """Set `xformOp:orient` of a prim in its own precision, appended to its ops if it has none.

    Raises:
        TypeError: `orientation` is not a Quatf or Quatd.
    """
    if type(orientation) not in _ORIENT_PRECISION:
        raise TypeError(f"orientation is a {type(orientation).__name__}; expected Gf.Quatf or Gf.Quatd")
    precision = _ORIENT_PRECISION[type(orientation)]
    op = _first(prim, UsdGeom.XformOp.TypeOrient, lambda xform: xform.AddOrientOp(precision))
    double = op.GetPrecision() == UsdGeom.XformOp.PrecisionDouble
    op.Set(Gf.Quatd(orientation) if double else Gf.Quatf(orientation))


def set_rotation(prim: Usd.Prim, rotation: Gf.Vec3f | Gf.Vec3d | Gf.Rotation) -> None:
    """Set `xformOp:rotateXYZ` [degrees] of a prim, appended to its ops if it has none.

    Raises:
        TypeError: `rotation` is neither a vector nor a Gf.Rotation.
    """
    if isinstance(rotation, Gf.Rotation):
        z, y, x = rotation.Decompose(Gf.Vec3d.ZAxis(), Gf.Vec3d.YAxis(), Gf.Vec3d.XAxis())
        rotation = Gf.Vec3d(x, y, z)
    elif not isinstance(rotation, (Gf.Vec3f, Gf.Vec3d)):
        raise TypeError(f"rotation is a {type(rotation).__name__}; expected Gf.Vec3f, Gf.Vec3d or Gf.Rotation")
    _set_vector(_first(prim, UsdGeom.XformOp.TypeRotateXYZ, lambda xform: xform.AddRotateXYZOp()), rotation)


def set_scale(prim: Usd.Prim, scale: Gf.Vec3f | tuple[float, float, float]) -> None:
    """Set the first scale of a prim, appended to its ops if it has none."""
    _set_vector(_first(prim, UsdGeom.XformOp.TypeScale, lambda xform: xform.AddScaleOp()), scale)


def set_transform_matrix(prim: Usd.Prim, transform: Gf.Matrix4d) -> None:
    """Set the first transform matrix of a prim, appended to its ops if it has none."""
    _first(prim, UsdGeom.XformOp.TypeTransform, lambda xform: xform.AddTransformOp()).Set(transform)


def set_transform_attributes(
    prim: Usd.Prim,
    location: Gf.Vec3d | None = None,
    orientation: Gf.Quatf | Gf.Quatd | None = None,
    rotation: Gf.Vec3f | Gf.Vec3d | Gf.Rotation | None = None,
    scale: Gf.Vec3f | tuple[float, float, float] | None = None,
    transform: Gf.Matrix4d | None = None,
) -> None:
    """Set those parts of a prim's local transform that are given; new ops are appended in the order of the list."""
    parts = (
        (set_transform_matrix, transform),
        (set_location, location),
        (set_orientation, orientation),
        (set_rotation, rotation),
        (set_scale, scale),
    )
    for setter, value in parts:
        if value is not None:
            setter(prim, value)


def _first(prim: Usd.Prim, kind: UsdGeom.XformOp.Type, add) -> UsdGeom.XformOp:
    """Return the first op of a kind that is not an inverse, or add one."""
    xformable = UsdGeom.Xformable(prim)
    ops = (op for op in xformable.GetOrderedXformOps() if op.GetOpType() == kind and not op.IsInverseOp())
    return next(ops, None) or add(xformable)


def _set_vector(op: UsdGeom.XformOp, value: Gf.Vec3f | Gf.Vec3d | tuple[float, float, float]) -> None:
    """Set three numbers in the op's own precision."""
    double = op.GetPrecision() == UsdGeom.XformOp.PrecisionDouble
    x, y, z = value
    op.Set(Gf.Vec3d(x, y, z) if double else Gf.Vec3f(x, y, z))
