"""Nodes that act on the instances or the prototypes of a PointInstancer instead of on the instancer itself."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from pxr import Usd, Vt

from usdsdg.arguments.values import vector
from usdsdg.distribution import Distribution, is_vector
from usdsdg.errors import ArgumentError, Unsupported
from usdsdg.graph.node import Node
from usdsdg.stage.geometry.instancers import (
    author_orientations,
    author_positions,
    author_scales,
    instance_names,
    is_instancer,
    local_orientations,
    local_positions,
    prototypes,
)
from usdsdg.stage.poses.rotations import euler_from_matrix, matrix_from_euler, matrix_from_quat, quat_from_matrix

# Attributes that have a value for each instance.
INSTANCE_ARRAYS = ("positions", "orientations", "scales", "velocities", "accelerations", "angularVelocities")
_AXES = "xyz"
_ROLES = ("position", "rotation", "scale", *(f"{role}_{axis}" for role in ("position", "rotation") for axis in _AXES))


class Objects(NamedTuple):
    """What a node acts on where its targets include PointInstancers.

    Attributes:
        node: the node with a name for each object in place of its targets, for draws; a list with one value for each
            target has one for each object.
        rows: which objects are those of each target.
    """

    node: Node
    rows: list[slice]

    def spread(self, column: Iterable[Any]) -> list[Any]:
        """Repeat the value of each target for all of its objects."""
        return [value for value, own in zip(column, self.rows) for _ in range(own.start, own.stop)]


def objects_of(node: Node, names: Sequence[Sequence[str]]) -> Objects:
    """Return the objects of a node, of which `names` are those of each target."""
    owners = [target for target, own in enumerate(names) for _ in own]

    def spread(role: str, value: Any) -> Any:
        is_list = isinstance(value, list) and len(value) == len(names) != len(owners)
        if isinstance(value, Distribution) or not is_list or (is_vector(value) and role[-2:] not in ("_x", "_y", "_z")):
            return value
        return [value[target] for target in owners]

    inputs = {role: spread(role, value) for role, value in node.inputs.items()}
    ends = np.cumsum([len(own) for own in names]).tolist()
    rows = [slice(end - len(own), end) for end, own in zip(ends, names)]
    return Objects(replace(node, inputs=inputs, prims=tuple(name for own in names for name in own)), rows)


def instances_or_self(prims: Sequence[Usd.Prim]) -> list[list[str]]:
    """Return for each prim the names of its instances, if it is a PointInstancer, else its path."""
    return [instance_names(prim) if is_instancer(prim) else [str(prim.GetPath())] for prim in prims]


def prototypes_or_self(prims: Sequence[Usd.Prim]) -> list[list[str]]:
    """Return for each prim the paths of its prototypes, if it is a PointInstancer, else its own."""
    return [[str(each.GetPath()) for each in (prototypes(p) if is_instancer(p) else [p])] for p in prims]


def pose_instances(prim: Usd.Prim, columns: Mapping[str, Sequence[Any] | np.ndarray], order: str) -> None:
    """Write poses of the instances, positions and scales in the instancer's space.

    Args:
        columns: values for each instance of position, rotation (Euler angles in the axis order `order` [degrees]),
            scale, or of single axes of the first two.

    Raises:
        Unsupported: there are others.
    """
    if others := sorted(set(columns) - set(_ROLES)):
        raise Unsupported(
            f"modify.pose: {', '.join(others)} cannot be given to point instances, as those of {prim.GetPath()}; use "
            f"{', '.join(_ROLES[:3])} or an axis of them, or prims in place of instances, as instantiate with "
            "mode='scene_instance' makes"
        )
    if "position" in columns:
        author_positions(prim, _vectors("position", columns["position"]))
    elif axes := _single_axes("position", columns):
        author_positions(prim, _replaced(local_positions(prim), axes))
    if "rotation" in columns:
        author_orientations(prim, _quats(_vectors("rotation", columns["rotation"]), order))
    elif axes := _single_axes("rotation", columns):
        angles = euler_from_matrix(matrix_from_quat(local_orientations(prim)), order)
        author_orientations(prim, _quats(_replaced(angles, axes), order))
    if "scale" in columns:
        author_scales(prim, _vectors("scale", columns["scale"]))


def role_of(attribute: str) -> str | None:
    """Return which part of an instance's pose the xform op of a prim is, as `modify.attribute` names it."""
    if attribute.startswith("xformOp:rotate") and len(attribute) == len("xformOp:rotateXYZ"):
        return "rotation"
    return {"xformOp:translate": "position", "xformOp:scale": "scale"}.get(attribute)


def is_per_instance(attribute: str) -> bool:
    """Whether `modify.attribute` sets this attribute of a PointInstancer for each instance."""
    return attribute in INSTANCE_ARRAYS or role_of(attribute) is not None


def set_per_instance(prim: Usd.Prim, attribute: str, column: Sequence[Any] | np.ndarray) -> None:
    """Set an attribute that `is_per_instance` to one value for each instance.

    Raises:
        ArgumentError: a value is not a vector, or of orientations a quaternion (real part first).
    """
    if role := role_of(attribute):
        pose_instances(prim, {role: column}, attribute[-3:])
    elif attribute == "orientations":
        reals_first = _vectors(attribute, column, 4)
        if not (lengths := np.linalg.norm(reals_first, axis=1)).all():
            raise ArgumentError(f"{prim.GetPath()}.orientations: a quaternion of zeros is no rotation")
        author_orientations(prim, reals_first[:, [1, 2, 3, 0]] / lengths[:, None])
    else:
        rows = np.ascontiguousarray(_vectors(attribute, column), np.float32)
        prim.GetAttribute(attribute).Set(Vt.Vec3fArray.FromNumpy(rows))


def _vectors(name: str, column: Sequence[Any] | np.ndarray, size: int = 3) -> np.ndarray:
    """Return (instances, size) numbers, of which one may stand for all of a row."""
    return np.array([vector(name, each, size) for each in column], np.float64).reshape(-1, size)


def _single_axes(role: str, columns: Mapping[str, Any]) -> dict[int, Any]:
    return {k: columns[f"{role}_{axis}"] for k, axis in enumerate(_AXES) if f"{role}_{axis}" in columns}


def _replaced(vectors: np.ndarray, axes: Mapping[int, Any]) -> np.ndarray:
    for axis, numbers in axes.items():
        vectors[:, axis] = numbers
    return vectors


def _quats(degrees: np.ndarray, order: str) -> np.ndarray:
    return quat_from_matrix(matrix_from_euler(degrees, order))
