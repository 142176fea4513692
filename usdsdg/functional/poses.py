"""Conversion of the functional API's pose arguments (relative_to, pivot, look_at) to local poses."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Usd

from usdsdg.arguments.prims import is_prim, one_prim, prims_of
from usdsdg.arguments.values import up_axis_vector
from usdsdg.errors import ArgumentError, Unsupported, counted
from usdsdg.functional.arguments import per_prim, rotations, vectors
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import picture_time
from usdsdg.stage.geometry.instancers import (
    author_orientations,
    author_positions,
    author_scales,
    instance_count,
)
from usdsdg.stage.poses.look_at import look_at_quaternions
from usdsdg.stage.poses.pivots import translations_about_pivots
from usdsdg.stage.poses.pose_batch import Rotations, author_poses
from usdsdg.stage.poses.relative_poses import relative_to_parents
from usdsdg.stage.poses.transforms import as_array, local_to_world, up_vector

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
    """Write the given parts of the poses; `modify.pose` documents the arguments."""
    if rotation is not None and look_at is not None:
        raise ArgumentError("rotation and look_at exclude each other; give one of them")
    if all(value is None for value in (position, rotation, scale, look_at, pivot)) or not prims:
        return
    count, time = len(prims), picture_time(prims[0].GetStage())
    order = rotation_order or get_settings().get_as_string(_ORDER_SETTING) or "XYZ"
    translate = None if position is None else vectors("position", position, count)
    rotate = None if rotation is None else rotations("rotation", rotation, count, order)
    sizes = None if scale is None else vectors("scale", scale, count, number_per_prim=True)
    if relative_to is not None:
        frames = [one_prim("relative_to", frame) for frame in per_prim(relative_to, count)]
        translate, rotate, sizes = relative_to_parents(prims, frames, translate, rotate, sizes)
    if look_at is not None:
        up = up_vector(prims[0].GetStage()) if look_at_up_axis is None else up_axis_vector(look_at_up_axis)
        ups = vectors("look_at_up_axis", up, count)
        rotate = Rotations(quats=look_at_quaternions(prims, translate, _targets(look_at, count), ups, time))
    if pivot is not None:
        translate = translations_about_pivots(prims, vectors("pivot", pivot, count), translate, rotate, sizes, time)
    author_poses(prims, translate=translate, rotate=rotate, scale=sizes)


def _targets(look_at: Any, count: int) -> Array:
    """Return (count, 3) world points; for a count of 1 several target prims are one target, their mean position.

    Raises:
        ArgumentError: the number of targets is neither 1 nor `count`.
    """
    if is_prim(look_at):
        return np.tile(_origin(prims_of(look_at)), (count, 1))
    if not isinstance(look_at, (list, tuple)) or not any(is_prim(target) for target in look_at):
        return vectors("look_at", look_at, count)
    if count == 1 and all(is_prim(target) for target in look_at):
        return _origin(prims_of(look_at))[None]
    if len(look_at) not in (1, count):
        targets, prims_ = counted(len(look_at), "target"), counted(count, "prim")
        raise ArgumentError(f"look_at has {targets} for {prims_}; give one, or one per prim")
    points = [_origin(prims_of(target)) if is_prim(target) else vectors("look_at", target, 1)[0] for target in look_at]
    return np.broadcast_to(np.array(points), (count, 3))


def _origin(prims: list[Usd.Prim]) -> Array:
    """Return the mean world position (3,) of the prims' origins in the next picture."""
    time = picture_time(prims[0].GetStage())
    return np.mean([as_array(local_to_world(prim, time))[3, :3] for prim in prims], axis=0)


def set_mixed_poses(
    prims: list[Usd.Prim],
    instancers: list[Usd.Prim],
    given: dict[str, Any],
    *,
    rotation_order: str | None,
    **others: Any,
) -> None:
    """Write poses of prims of which some are PointInstancers: a list has a value for each prim and each instance.

    Args:
        given: position, rotation and scale of `set_poses`, whose other arguments are `rotation_order` and `others`.
    """
    sizes = [instance_count(prim) if prim in instancers else 1 for prim in prims]
    first = np.cumsum([0, *sizes])
    ordinary = [row for row, prim in enumerate(prims) if prim not in instancers]
    parts = {name: _of_all(value, int(first[-1])) for name, value in given.items()}
    for row, prim in enumerate(prims):
        if prim in instancers:
            own = {
                name: value[first[row] : first[row + 1]] if isinstance(value, _Rows) else value
                for name, value in parts.items()
            }
            set_instancer_poses(prim, own["position"], own["rotation"], rotation_order, own["scale"], **others)
    own = {
        name: [value[first[row]] for row in ordinary] if isinstance(value, _Rows) else value
        for name, value in parts.items()
    }
    set_poses([prims[row] for row in ordinary], rotation_order=rotation_order, **own, **others)


class _Rows(list[Any]):
    """One value for each prim and each instance."""


def _of_all(value: Any, count: int) -> Any:
    """Return the values of a list or array of `count` as rows; other values as they are."""
    rows = value.tolist() if isinstance(value, np.ndarray) else value
    is_one_each = isinstance(rows, list) and len(rows) == count
    return _Rows(rows) if is_one_each and (count != 3 or isinstance(rows[0], (list, tuple))) else value


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
    count = instance_count(prim)
    order = rotation_order or get_settings().get_as_string(_ORDER_SETTING) or "XYZ"
    if position is not None:
        author_positions(prim, vectors("position", position, count))
    if rotation is not None:
        author_orientations(prim, rotations("rotation", rotation, count, order).quats())
    if scale is not None:
        author_scales(prim, vectors("scale", scale, count, number_per_prim=True))
