"""Poses of prims: `rep.modify.pose`."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from pxr import Gf, Sdf, Usd

from usdsdg.arguments.prims import prim_at
from usdsdg.arguments.values import up_axis_vector, vector
from usdsdg.distribution import Distribution, draw_column
from usdsdg.errors import ArgumentError
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act
from usdsdg.graph.node import Node, ReplicatorItem, current_trigger, item_of, plain
from usdsdg.modify.numbers import draw_numbers
from usdsdg.modify.point_instances import instances_or_self, objects_of, pose_instances
from usdsdg.modify.prims import target_prims
from usdsdg.session.session import current
from usdsdg.session.timeline import picture_time
from usdsdg.stage.geometry.instancers import is_instancer
from usdsdg.stage.poses import pivots, transforms
from usdsdg.stage.poses.look_at import author_look_at, author_look_ats
from usdsdg.stage.poses.pose_batch import Rotations, author_poses
from usdsdg.stage.poses.rotations import ROTATION_ORDERS, euler_from_matrix, matrix_from_euler
from usdsdg.stage.poses.transforms import up_vector
from usdsdg.stage.poses.xform_ops import author_pose, local_euler, local_translation

_AXES = "xyz"
# Inputs that are not sampled per prim.
_SETTINGS = ("attribute", "rotation_order")
_OPTIONAL = (
    *("position", "position_x", "position_y", "position_z", "rotation", "rotation_x", "rotation_y", "rotation_z"),
    *("rotation_order", "scale", "size", "pivot", "look_at", "look_at_up_axis"),
)
# Inputs that can be written for all prims in one batch.
_BATCHED = ("position", "rotation", "scale", "look_at", "look_at_up_axis")


def pose(
    position: Any = None, position_x: Any = None, position_y: Any = None, position_z: Any = None, rotation: Any = None,
    rotation_x: Any = None, rotation_y: Any = None, rotation_z: Any = None, rotation_order: str = "XYZ",
    scale: Any = None, size: Any = None, pivot: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    input_prims: Any = None, name: str | None = None,
) -> ReplicatorItem:  # fmt: skip
    """Set the given parts of the pose, in the order position, pivot, rotation, scale or size, look-at.

    Every value is one for all prims, a list of one per prim, or a distribution. Parts that are not given are unchanged:
    with `position_z` alone x and y keep their values. Of a PointInstancer each instance is posed, in its space, by
    position, rotation and scale; a list then has one value for each instance too, or one for each prim.

    Args:
        position: (x, y, z) in the parent's space [stage units]; or some of position_x, position_y, position_z.
        rotation: angles about x, y, z [degrees]; or some of rotation_x, rotation_y, rotation_z.
        rotation_order: "XYZ" rotates about x first. An existing rotate or orient op of the prim is used.
        scale: factors, or one for all axes.
        size: edge lengths of a box along the prim's own axes [stage units], or one for all axes. One scale for all axes
            is set, with which the untransformed geometry just fits into it; axes without extent do not count.
        pivot: point that `position` places and that rotations are about; -1 to 1 on each axis of the prim's own
            bounding box (0: its center).
        look_at: a point of the world, a prim, or several prims (the mean of their origins). Cameras look at it, for
            other prims -Z points at it.
        look_at_up_axis: world direction that `look_at` keeps up, or "X", "Y" or "Z"; the stage's up axis by default.

    Raises:
        ArgumentError: (a ValueError) position is given with a single axis of it, rotation likewise, scale with size,
            rotation with look_at, or an unknown rotation order.
    """
    single = {
        "position": {"position_x": position_x, "position_y": position_y, "position_z": position_z},
        "rotation": {"rotation_x": rotation_x, "rotation_y": rotation_y, "rotation_z": rotation_z},
    }
    given = {role: value for axes in single.values() for role, value in axes.items() if value is not None}
    _exclude("position", position, *_given(single["position"]))
    _exclude("rotation", rotation, *_given(single["rotation"]))
    _exclude("scale", scale, *_given({"size": size}))
    any_rotation = rotation if rotation is not None else next(iter(_given(single["rotation"])), None)
    _exclude("rotation", any_rotation, *_given({"look_at": look_at}))
    if str(rotation_order).upper() not in ROTATION_ORDERS:
        raise ArgumentError(f"modify.pose: rotation_order={rotation_order!r}; known: {', '.join(ROTATION_ORDERS)}")
    values = dict(position=position, pivot=pivot, rotation=rotation, scale=scale, size=size, look_at=look_at)
    given |= {role: value for role, value in values.items() if value is not None}
    attribute = ",".join(given)
    if look_at_up_axis is not None:
        given["look_at_up_axis"] = up_axis_vector(look_at_up_axis)
    if str(rotation_order).upper() != "XYZ":
        given["rotation_order"] = str(rotation_order).upper()
    return act("OgnWritePose", input_prims, name=name, attribute=attribute, **given)


def _given(arguments: dict[str, Any]) -> list[str]:
    return [role for role, value in arguments.items() if value is not None]


def _exclude(role: str, value: Any, *others: str) -> None:
    if value is not None and others:
        raise ArgumentError(f"modify.pose: give {role} or {', '.join(others)}, not both")


def apply_or_schedule_pose(item: ReplicatorItem, **pose_values: Any) -> None:
    """Write constants immediately and distributions at every firing, with directions to look that these change."""
    given = {role: value for role, value in pose_values.items() if value is not None}
    if "look_at_up_axis" in given:
        given["look_at_up_axis"] = up_axis_vector(given["look_at_up_axis"])
    later: dict[str, Any] = {role: value for role, value in given.items() if isinstance(value, Distribution)}
    # The up axis only has a meaning together with the target.
    looks = {role: given[role] for role in ("look_at", "look_at_up_axis") if role in given}
    if looks.keys() & later.keys():
        later |= looks
    looks_later = not looks.keys() & later.keys() and "look_at" in looks and _is_turned_later(looks["look_at"], later)
    now = {role: value for role, value in given.items() if role not in later and not (looks_later and role in looks)}
    if now:
        write_pose(Node(kind="OgnWritePose", inputs={r: plain(v) for r, v in now.items()}, prims=item.prims), 0)
    if later:
        pose(**later, input_prims=item)
    if looks_later:
        # A node of its own: the key of the other one, and with it what is drawn for positions, stays.
        pose(**looks, input_prims=item)


def _is_turned_later(target: Any, later: dict[str, Any]) -> bool:
    """Whether new prims that look at a target have to be turned when the graph runs, since they or the target move.

    As in Replicator a trigger turns them again to the prims of an item. Paths and points are where they are now.
    """
    if "position" in later:
        return True
    followed = [item_of(each) for each in (target if isinstance(target, (list, tuple)) else [target])]
    followed = [each for each in followed if isinstance(each, ReplicatorItem) and not isinstance(each, Distribution)]
    targets = [path for item in followed for path in item.prims]
    waiting = [path for node in current().graph.impulses for path in node.prims]
    moves_now = any(path == above or path.startswith(f"{above}/") for path in targets for above in waiting)
    return bool(targets) and (moves_now or current_trigger() is not None)


@action("OgnWritePose", *_OPTIONAL)
def write_pose(node: Node, execution: int) -> None:
    """Write the poses that an "OgnWritePose" node samples for one execution."""
    order = node.inputs.get("rotation_order", "XYZ")
    targets = _targets(node)
    if targets.have_instancers:
        _pose_objects(node, targets.prims, execution, order)
        return
    drawn = _columns(node, execution)
    if _pose_all(targets, drawn, order):
        return
    for index, prim in enumerate(targets.prims):
        _pose_one(prim, {role: column[index] for role, column in drawn.items()}, order)


class _Targets(NamedTuple):
    """The prims of a node."""

    prims: list[Usd.Prim]
    have_instancers: bool  # PointInstancers are among them
    are_distinct: bool
    are_apart: bool  # distinct, and none is below another one


def _targets(node: Node) -> _Targets:
    """Return the prims of a node; what they are is that of when they are looked up: none becomes an instancer later."""
    prims = target_prims(node)
    targets = node.state.get("targets")
    if targets is None or targets.prims is not prims:
        apart = Sdf.Path.RemoveDescendentPaths([prim.GetPath() for prim in prims])
        targets = node.state["targets"] = _Targets(
            prims,
            have_instancers=any(map(is_instancer, prims)),
            are_distinct=len(set(prims)) == len(prims),
            are_apart=len(apart) == len(prims),
        )
    return targets


def _pose_objects(node: Node, prims: list[Usd.Prim], execution: int, order: str) -> None:
    """Write the poses of prims, of PointInstancers those of each instance."""
    objects = objects_of(node, instances_or_self(prims))
    drawn = _columns(objects.node, execution)
    for prim, rows in zip(prims, objects.rows):
        own = {role: column[rows] for role, column in drawn.items()}
        if is_instancer(prim):
            pose_instances(prim, own, order)
        else:
            _pose_one(prim, {role: column[0] for role, column in own.items()}, order)


def _columns(node: Node, execution: int) -> dict[str, Any]:
    return {role: _column(role, value, node, execution) for role, value in node.inputs.items() if role not in _SETTINGS}


def _pose_all(targets: _Targets, drawn: dict[str, Any], order: str) -> bool:
    """Write position, rotation, scale and look-at of all prims in batches; return False, writing nothing, for others.

    Also for prims of which one may change where another one is, or where it looks.
    """
    if not drawn.keys() <= set(_BATCHED) or order != "XYZ" or not targets.are_distinct:
        return False
    columns = {role: _rows(column) for role, column in drawn.items() if role != "look_at"}
    if "look_at" in drawn:
        columns["look_at"] = _points(drawn["look_at"], targets)
    if any(column is None for column in columns.values()):
        return False
    rotation = columns.get("rotation")
    author_poses(
        targets.prims,
        translate=columns.get("position"),
        rotate=None if rotation is None else Rotations(degrees=rotation),
        scale=columns.get("scale"),
    )
    if (points := columns.get("look_at")) is not None:
        stage = targets.prims[0].GetStage()
        up = columns.get("look_at_up_axis")
        author_look_ats(targets.prims, points, up_vector(stage) if up is None else up, picture_time(stage))
    return True


def _points(column: Sequence[Any] | np.ndarray, targets: _Targets) -> np.ndarray | None:
    """Return points of the world, (N, 3) or (1, 3) for all prims; None where one has to be found after the other.

    That is where what a prim looks at, or the prim itself, moves with one that is posed.
    """
    if not targets.prims or not targets.are_apart:
        return None
    if isinstance(column, np.ndarray):
        return _rows(column)
    values = column[:1] if all(each is column[0] for each in column) else column
    posed = {prim.GetPath() for prim in targets.prims}
    for path in {path for each in values for path in _paths(plain(each))}:
        if posed.intersection(Sdf.Path(path).GetAncestorsRange()):
            return None
    return np.array([tuple(point_of("look_at", each)) for each in values])


def _paths(target: Any) -> Sequence[str]:
    paths = [target] if isinstance(target, str) else target
    return paths if is_paths(paths) else ()


def _rows(column: Sequence[Any] | np.ndarray) -> np.ndarray | None:
    """Convert a column to (N, 3) numbers, one number filling a row; None if it has to be converted value by value."""
    try:
        rows = np.asarray(column, np.float64)
    except (TypeError, ValueError):
        return None
    if rows.ndim == 1:
        rows = np.repeat(rows[:, None], 3, axis=1)
    return rows if rows.shape == (len(column), 3) else None


def _column(role: str, value: Any, node: Node, execution: int) -> Sequence[Any] | np.ndarray:
    """One value per prim."""
    if role[-2:] in ("_x", "_y", "_z"):
        return draw_numbers(role, node, execution)
    # Several prims are one target, their mean position, even if there is one of them per posed prim.
    if role == "look_at" and is_paths(value):
        return [value] * len(node.prims)
    return draw_column(value, node, execution, role)


def is_paths(value: Any) -> bool:
    """Whether a value is a list of prim paths."""
    return isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(each, str) for each in value)


def _pose_one(prim: Usd.Prim, values: dict[str, Any], order: str) -> None:
    parts: dict[str, Any] = {}
    if "position" in values:
        parts["translate"] = Gf.Vec3d(vector("position", values["position"]))
    elif axes := _single_axes("position", values):
        parts["translate"] = _replaced(local_translation(prim), axes)
    if "pivot" in values:
        pivots.set_pivot(prim, vector("pivot", values["pivot"]), picture_time(prim.GetStage()))
    if "rotation" in values:
        parts["rotate_xyz"] = _in_xyz(vector("rotation", values["rotation"]), order)
    elif axes := _single_axes("rotation", values):
        parts["rotate_xyz"] = _in_xyz(_replaced(local_euler(prim, order), axes), order)
    if "scale" in values:
        parts["scale"] = Gf.Vec3d(vector("scale", values["scale"]))
    elif "size" in values:
        parts["scale"] = _scale_for(prim, vector("size", values["size"]))
    author_pose(prim, **parts)
    if "look_at" in values:
        up = values.get("look_at_up_axis")
        upwards = None if up is None else vector("look_at_up_axis", up)
        author_look_at(prim, point_of("look_at", values["look_at"]), upwards, picture_time(prim.GetStage()))


def _single_axes(role: str, values: dict[str, Any]) -> dict[int, float]:
    found = {}
    for axis, letter in enumerate(_AXES):
        if (value := values.get(f"{role}_{letter}")) is not None:
            found[axis] = float(value)
    return found


def _replaced(numbers: Sequence[float] | np.ndarray, axes: dict[int, float]) -> Gf.Vec3d:
    return Gf.Vec3d(*(axes.get(axis, float(number)) for axis, number in enumerate(numbers)))


def _in_xyz(degrees: Sequence[float] | Gf.Vec3d, order: str) -> Gf.Vec3d:
    if order != "XYZ":
        degrees = euler_from_matrix(matrix_from_euler(tuple(degrees), order)).tolist()
    return Gf.Vec3d(*degrees)


def _scale_for(prim: Usd.Prim, size: list[float]) -> Gf.Vec3d | None:
    """Return the scale with which the prim just fits into a box of a size; None if it has no extent on any axis."""
    extents = pivots.extents(prim, picture_time(prim.GetStage()))
    ratios = [edge / length for edge, length in zip(size, extents.tolist()) if length > 0]
    return Gf.Vec3d(min(ratios)) if ratios else None


def point_of(role: str, target: Any) -> Gf.Vec3d:
    """Return a world point, given as coordinates or as prims (the mean of their origins in the next picture).

    Distributions draw prims as they were listed: paths, prims of the stage, or items.
    """
    target = plain(target)
    if paths := _paths(target):
        prims = [prim_at(path) for path in paths]
        time = picture_time(prims[0].GetStage())
        origins = [tuple(transforms.local_to_world(prim, time).ExtractTranslation()) for prim in prims]
        return Gf.Vec3d(*np.mean(origins, axis=0).tolist())
    return Gf.Vec3d(*vector(role, target))
