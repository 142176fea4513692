"""Positions, orientations and scales of prims as float32 arrays; quaternions are (w, x, y, z)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Gf, Usd, UsdGeom

from usdsdg.stage.poses.rotations import compose, decompose
from usdsdg.stage.poses.transforms import as_array, inverses_of_parents, local_matrices, parents_to_world
from usdsdg.stage.poses.xform_ops import author_pose

TRANSLATE, ORIENT, SCALE = "xformOp:translate", "xformOp:orient", "xformOp:scale"
_UNITS = ":unitsResolve"
_OTHER_OPS = {f"xformOp:rotate{order}" for order in ("X", "Y", "Z", "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")}
_OTHER_OPS.add("xformOp:transform")


def world_poses(prims: Sequence[Usd.Prim]) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (N, 3) and orientations (N, 4) in the world [stage units], without scale."""
    return _poses(_to_world(prims))


def local_poses(prims: Sequence[Usd.Prim]) -> tuple[np.ndarray, np.ndarray]:
    """Return translations (N, 3) and orientations (N, 4) relative to the parents, without scale."""
    return _poses(local_matrices(prims))


def local_from_world(
    prims: Sequence[Usd.Prim], positions: np.ndarray, orientations: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return translations and orientations relative to the prims' parents of poses in the world.

    Raises:
        DegenerateFrame: an ancestor is scaled to zero.
    """
    return _poses(compose(positions, xyzw(orientations)) @ inverses_of_parents(prims), np.float64)


def set_local_poses(
    prims: Sequence[Usd.Prim], translations: np.ndarray | None, orientations: np.ndarray | None, *, strict: bool = True
) -> None:
    """Author translations (N, 3) and orientations (N, 4) in the ops translate and orient.

    Args:
        strict: refuse prims without these ops; otherwise write the ops that a prim has, and add missing ones.

    Raises:
        AssertionError: `strict`, and a prim lacks an op.
    """
    for index, prim in enumerate(prims):
        move = None if translations is None else Gf.Vec3d(*translations[index].tolist())
        turn = None if orientations is None else Gf.Quatd(*orientations[index].tolist())
        if not strict:
            author_pose(prim, translate=move, orient=turn)
            continue
        if move is not None:
            _set(prim, TRANSLATE, move)
        if turn is not None:
            _set(prim, ORIENT, turn)


def set_world_poses(
    prims: Sequence[Usd.Prim], positions: np.ndarray | None, orientations: np.ndarray | None, *, strict: bool = True
) -> None:
    """Author poses in the world; None keeps the present positions or orientations. See `set_local_poses`."""
    if positions is None or orientations is None:
        now = world_poses(prims)
        positions = now[0] if positions is None else positions
        orientations = now[1] if orientations is None else orientations
    set_local_poses(prims, *local_from_world(prims, positions, orientations), strict=strict)


def move_to_local(
    prims: Sequence[Usd.Prim],
    frames: Sequence[Usd.Prim],
    translations: np.ndarray | None,
    orientations: np.ndarray | None,
) -> None:
    """Place prims at poses relative to the parents of `frames`: (N, 3) and (N, 4), None keeps what is there."""
    now = local_from_world(frames, *world_poses(prims))
    moves = now[0] if translations is None else translations
    turns = now[1] if orientations is None else orientations
    set_world_poses(prims, *_poses(compose(moves, xyzw(turns)) @ parents_to_world(frames), np.float64), strict=False)


def local_scales(prims: Sequence[Usd.Prim], *, strict: bool = True) -> np.ndarray:
    """Return the values (N, 3) of the scale ops; 1 without one unless `strict`.

    Raises:
        AssertionError: `strict`, and a prim has no scale op.
    """
    for prim in prims if strict else ():
        _required(prim, SCALE)
    values = [prim.GetAttribute(SCALE).Get() if prim.HasAttribute(SCALE) else None for prim in prims]
    return np.array([(1.0, 1.0, 1.0) if value is None else tuple(value) for value in values], np.float32)


def world_scales(prims: Sequence[Usd.Prim]) -> np.ndarray:
    """Return the scales (N, 3) of the matrices to the world."""
    return decompose(_to_world(prims)).scale.astype(np.float32)


def set_local_scales(prims: Sequence[Usd.Prim], scales: np.ndarray, *, strict: bool = True) -> None:
    """Author scales (N, 3); missing ops are added unless `strict`.

    Raises:
        AssertionError: `strict`, and a prim has no scale op.
    """
    for prim, scale in zip(prims, scales, strict=True):
        if strict:
            _set(prim, SCALE, Gf.Vec3d(*scale.tolist()))
        else:
            author_pose(prim, scale=scale.tolist())


def reset_ops(prims: Sequence[Usd.Prim]) -> None:
    """Give prims the ops translate, orient and scale, and no others; their poses in the world stay."""
    before = world_poses(prims)
    for prim in prims:
        _standard_ops(prim)
    set_world_poses(prims, *before)


def xyzw(orientations: np.ndarray) -> np.ndarray:
    """Return quaternions (..., 4) given as w, x, y, z in the order x, y, z, w."""
    return np.roll(orientations, -1, -1)


def wxyz(orientations: np.ndarray) -> np.ndarray:
    """Return quaternions (..., 4) given as x, y, z, w in the order w, x, y, z."""
    return np.roll(orientations, 1, -1)


def _to_world(prims: Sequence[Usd.Prim]) -> np.ndarray:
    cache = UsdGeom.XformCache()
    return np.stack([as_array(cache.GetLocalToWorldTransform(prim)) for prim in prims])


def _poses(matrices: np.ndarray, dtype: type = np.float32) -> tuple[np.ndarray, np.ndarray]:
    pose = decompose(matrices)
    return pose.translate.astype(dtype), wxyz(pose.rotation).astype(dtype)


def _required(prim: Usd.Prim, name: str) -> Usd.Attribute:
    if not prim.HasAttribute(name):
        raise AssertionError(
            f"{prim.GetPath()} has no {name}. Pass reset_xform_op_properties=True to its wrapper, or call "
            "reset_xform_op_properties()"
        )
    return prim.GetAttribute(name)


def _set(prim: Usd.Prim, name: str, value: Gf.Vec3d | Gf.Quatd) -> None:
    """Set an op in its own precision."""
    attribute = _required(prim, name)
    attribute.Set(attribute.GetTypeName().type.pythonClass(value))


def _standard_ops(prim: Usd.Prim) -> None:
    xformable = UsdGeom.Xformable(prim)
    scale_units = prim.GetAttribute(SCALE + _UNITS).Get() if prim.HasAttribute(SCALE + _UNITS) else None
    for name in prim.GetPropertyNames():
        if name in _OTHER_OPS or (name.startswith("xformOp:") and name.endswith(_UNITS)):
            prim.RemoveProperty(name)
    kinds = UsdGeom.XformOp.TypeTranslate, UsdGeom.XformOp.TypeOrient, UsdGeom.XformOp.TypeScale
    xformable.ClearXformOpOrder()
    ops = []
    for name, kind in zip((TRANSLATE, ORIENT, SCALE), kinds, strict=True):
        if prim.HasAttribute(name):
            ops.append(UsdGeom.XformOp(prim.GetAttribute(name)))
        else:
            ops.append(xformable.AddXformOp(kind, UsdGeom.XformOp.PrecisionDouble))
    if ops[2].Get() is None:
        ops[2].Set(Gf.Vec3d(1.0))
    if scale_units is not None:
        _set(prim, SCALE, Gf.CompMult(Gf.Vec3d(ops[2].Get()), Gf.Vec3d(scale_units)))
    xformable.SetXformOpOrder(ops)
