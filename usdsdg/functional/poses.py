"""Poses as the functional API takes them: relative to another prim, around a pivot, facing a target."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Sdf, Usd, UsdGeom

from usdsdg.errors import ArgumentError, BadPrim, DegenerateFrame, Unsupported
from usdsdg.functional.arguments import one_prim, per_prim, prims_of, rotations, vectors
from usdsdg.graph.node import ReplicatorItem
from usdsdg.session.settings_store import get_settings
from usdsdg.stage.poses.look_at import facing
from usdsdg.stage.poses.pose_batch import Rotations, author_poses
from usdsdg.stage.poses.rotations import decompose, quat_from_matrix
from usdsdg.stage.poses.transforms import as_array, local_to_world, up_axis

Array = NDArray[np.float64]

_ORDER_SETTING = "/app/primCreation/DefaultRotationOrder"


def set_poses(
    prims: list[Usd.Prim],
    *,
    position: Any = None,
    rotation: Any = None,
    rotation_order: str | None = None,
    scale: Any = None,
    relative_to: Any = None,
    look_at: Any = None,
    look_at_up_axis: Any = None,
    pivot: Any = None,
) -> None:
    """Write the parts of the poses that are given; `modify.pose` says what each argument means."""
    if rotation is not None and look_at is not None:
        raise ArgumentError("rotation and look_at exclude each other; give one of them")
    if all(value is None for value in (position, rotation, scale, look_at, pivot)) or not prims:
        return
    count = len(prims)
    order = rotation_order or get_settings().get_as_string(_ORDER_SETTING) or "XYZ"
    translate = None if position is None else vectors("position", position, count)
    rotate = None if rotation is None else rotations("rotation", rotation, count, order)
    sizes = None if scale is None else vectors("scale", scale, count, number_per_prim=True)
    if relative_to is not None:
        translate, rotate, sizes = _from_frames(prims, relative_to, translate, rotate, sizes)
    if look_at is not None:
        rotate = _towards(prims, translate, look_at, look_at_up_axis)
    if pivot is not None:
        translate = _around_pivots(prims, vectors("pivot", pivot, count), translate, rotate, sizes)
    author_poses(prims, translate=translate, rotate=rotate, scale=sizes)


def _from_frames(
    prims: list[Usd.Prim], relative_to: Any, translate: Array | None, rotate: Rotations | None, scale: Array | None
) -> tuple[Array | None, Rotations | None, Array | None]:
    """Parts given in the space of other prims, as each prim's parent needs them."""
    frames = [one_prim("relative_to", frame) for frame in per_prim(relative_to, len(prims))]
    placed = np.tile(np.eye(4), (len(prims), 1, 1))
    if rotate is not None:
        placed[:, :3, :3] = rotate.matrices()
    if scale is not None:
        placed[:, :3, :3] = scale[:, :, None] * placed[:, :3, :3]
    if translate is not None:
        placed[:, 3, :3] = translate
    to_world = np.stack([as_array(local_to_world(frame)) for frame in frames])
    pose = decompose(placed @ to_world @ _inverses(prims, _parents_to_world(prims)))
    return (
        None if translate is None else pose.translate,
        None if rotate is None else Rotations(quats=pose.rotation),
        None if scale is None else pose.scale,
    )


def _towards(prims: list[Usd.Prim], translate: Array | None, look_at: Any, up: Any) -> Rotations:
    """Rotations in the parents' spaces with which -Z of each prim (or of its camera) points at its target."""
    stage = prims[0].GetStage()
    axis = up_axis(stage)
    to_world = _parents_to_world(prims)
    where = _local_matrices(prims)[:, 3, :3] if translate is None else translate
    eyes = np.einsum("ni,nij->nj", np.c_[where, np.ones(len(prims))], to_world)[:, :3]
    default_up = (0.0, 0.0, 1.0) if axis == "Z" else (0.0, 1.0, 0.0)
    ups = vectors("look_at_up_axis", default_up if up is None else up, len(prims))
    turned = facing(eyes, _targets(look_at, len(prims)), ups, stage_up_axis=axis)
    for row, prim in enumerate(prims):
        # A camera made by rep.create.camera is turned against the object that carries it.
        if (camera := _carried_camera(prim)) is not None:
            turn = decompose(as_array(UsdGeom.Xformable(camera).GetLocalTransformation())[None])
            turned[row] = Rotations(quats=turn.rotation).matrices()[0].T @ turned[row]
    parents = Rotations(quats=decompose(to_world).rotation).matrices()
    return Rotations(quats=quat_from_matrix(turned @ parents.transpose(0, 2, 1)))


def _targets(look_at: Any, count: int) -> Array:
    """(count, 3) world points; several prims for one prim that looks are one target in their middle.

    Raises:
        ArgumentError: as many targets as neither one nor the number of prims.
    """
    if isinstance(look_at, (str, Sdf.Path, Usd.Prim, ReplicatorItem)):
        return np.tile(_middle(prims_of(look_at)), (count, 1))
    if not isinstance(look_at, (list, tuple)) or not any(_is_prim(target) for target in look_at):
        return vectors("look_at", look_at, count)
    if count == 1 and all(_is_prim(target) for target in look_at):
        return _middle(prims_of(look_at))[None]
    if len(look_at) not in (1, count):
        raise ArgumentError(f"look_at has {len(look_at)} targets for {count} prims; give one, or one per prim")
    points = [_middle(prims_of(target)) if _is_prim(target) else vectors("look_at", target, 1)[0] for target in look_at]
    return np.broadcast_to(np.array(points), (count, 3))


def _is_prim(target: Any) -> bool:
    return isinstance(target, (str, Sdf.Path, Usd.Prim, ReplicatorItem))


def _middle(prims: list[Usd.Prim]) -> Array:
    return np.mean([as_array(local_to_world(prim))[3, :3] for prim in prims], axis=0)


def _carried_camera(prim: Usd.Prim) -> Usd.Prim | None:
    if not (prim.HasAttribute("replicatorXform") or prim.HasAttribute("replicatorCameraXform")):
        return None
    return next((child for child in prim.GetChildren() if child.IsA(UsdGeom.Camera)), None)


def _around_pivots(
    prims: list[Usd.Prim], pivot: Array, translate: Array | None, rotate: Rotations | None, scale: Array | None
) -> Array:
    """Translations that put each pivot point at the position given, or leave it where it is."""
    points, before = _pivot_points(prims, pivot), _local_matrices(prims)
    if translate is None:
        translate = np.einsum("ni,nij->nj", points, before[:, :3, :3]) + before[:, 3, :3]
    now = decompose(before)
    turned = (Rotations(quats=now.rotation) if rotate is None else rotate).matrices()
    sizes = now.scale if scale is None else scale
    return translate - np.einsum("ni,nij->nj", points * sizes, turned)


def _pivot_points(prims: list[Usd.Prim], pivot: Array) -> Array:
    """Points in the prims' own spaces; -1 and 1 are the faces of the bounding box, 0 its middle.

    Raises:
        BadPrim: a prim has no extent.
    """
    bounds = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_, UsdGeom.Tokens.render])
    points = []
    for prim, normalized in zip(prims, pivot):
        box = bounds.ComputeUntransformedBound(prim).ComputeAlignedRange()
        if box.IsEmpty():
            raise BadPrim(f"{prim.GetPath()} has no extent, so it has no pivot; leave pivot out")
        low, high = np.array(box.GetMin()), np.array(box.GetMax())
        points.append(low + (high - low) * (normalized + 1) / 2)
    return np.array(points)


def _local_matrices(prims: list[Usd.Prim]) -> Array:
    cache = UsdGeom.XformCache()
    return np.stack([as_array(cache.GetLocalTransformation(prim)[0]) for prim in prims])


def _parents_to_world(prims: list[Usd.Prim]) -> Array:
    """(N, 4, 4); the identity for prims that reset the transform stack."""
    cache, known = UsdGeom.XformCache(), {}
    matrices = []
    for prim in prims:
        if UsdGeom.Xformable(prim).GetResetXformStack():
            matrices.append(np.eye(4))
            continue
        path = prim.GetPath().GetParentPath()
        if path not in known:
            known[path] = as_array(cache.GetParentToWorldTransform(prim))
        matrices.append(known[path])
    return np.stack(matrices)


def _inverses(prims: list[Usd.Prim], matrices: Array) -> Array:
    """Inverse of each prim's matrix.

    Raises:
        DegenerateFrame: an ancestor is scaled to zero.
    """
    flat = np.abs(np.linalg.det(matrices)) < 1e-30
    if flat.any():
        path = prims[int(np.argmax(flat))].GetPath()
        raise DegenerateFrame(f"{path} cannot be placed: an ancestor is scaled to zero")
    return np.asarray(np.linalg.inv(matrices), np.float64)


def set_instancer_poses(
    prim: Usd.Prim, position: Any, rotation: Any, rotation_order: str | None, scale: Any, **others: Any
) -> None:
    """Write positions, orientations and scales of all instances of a PointInstancer.

    Raises:
        Unsupported: look_at, pivot or relative_to are given.
    """
    if given := [name for name, value in others.items() if value is not None]:
        raise Unsupported(
            f"{given[0]} for the point instancer {prim.GetPath()} is not available; compute the positions and "
            "rotations of the instances and pass these"
        )
    instancer = UsdGeom.PointInstancer(prim)
    count = len(instancer.GetProtoIndicesAttr().Get() or ())
    order = rotation_order or get_settings().get_as_string(_ORDER_SETTING) or "XYZ"
    if position is not None:
        instancer.CreatePositionsAttr().Set(vectors("position", position, count).astype(np.float32))
    if rotation is not None:
        quats = rotations("rotation", rotation, count, order).quats()
        instancer.CreateOrientationsAttr().Set(quats.astype(np.float16))
    if scale is not None:
        sizes = vectors("scale", scale, count, number_per_prim=True)
        instancer.CreateScalesAttr().Set(sizes.astype(np.float32))
