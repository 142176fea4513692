"""Random rotations: `rep.randomizer.rotation`."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from usdsdg.arguments.values import vector
from usdsdg.errors import ArgumentError
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act
from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.graph.sampling import get_global_seed, own_seed, uniforms
from usdsdg.modify.prims import target_prims
from usdsdg.stage.geometry.instancers import author_orientations, instance_names, is_instancer
from usdsdg.stage.poses.pose_batch import Rotations, author_poses
from usdsdg.stage.poses.rotations import euler_xyz_from_quat


def rotation(
    min_angle: tuple[float, float, float] = (-180.0, -180.0, -180.0),
    max_angle: tuple[float, float, float] = (180.0, 180.0, 180.0),
    seed: int | None = None,
    input_prims: Any = None,
) -> ReplicatorItem:
    """Set a random rotation of each prim: uniform on SO(3) by default, else Euler angles uniform within the bounds.

    Of a PointInstancer each instance is rotated.

    Args:
        min_angle: lowest angles about x, y, z [degrees], or one for all; `max_angle` the highest.
        seed: replaces the global seed.

    Raises:
        ArgumentError: a bound is not three numbers, `min_angle` is above `max_angle`, or the seed is not an integer.
    """
    lower, upper = vector("min_angle", min_angle), vector("max_angle", max_angle)
    if any(low > high for low, high in zip(lower, upper)):
        raise ArgumentError(f"randomizer.rotation: min_angle={min_angle!r} is above max_angle={max_angle!r}")
    angles: dict[str, Any] = dict(minAngle=tuple(lower), maxAngle=tuple(upper))
    return act("OgnRotation", input_prims, attribute="rotation", seed=own_seed(seed), **angles)


@action("OgnRotation", "seed")
def _rotate(node: Node, execution: int) -> None:
    lower, upper = (np.asarray(node.inputs[name], float) for name in ("minAngle", "maxAngle"))
    seed = node.inputs.get("seed", get_global_seed())
    all_rotations = (lower == -180.0).all() and (upper == 180.0).all()

    def angles(names: Sequence[str]) -> np.ndarray:
        u = uniforms(seed, node.key, execution, names, 3)
        return euler_xyz_from_quat(uniform_quaternions(u)) if all_rotations else lower + u * (upper - lower)

    prims = target_prims(node)
    single = [prim for prim in prims if not is_instancer(prim)]
    if single:
        author_poses(single, rotate=Rotations(degrees=angles([str(prim.GetPath()) for prim in single])))
    for instancer in (prim for prim in prims if is_instancer(prim)):
        author_orientations(instancer, Rotations(degrees=angles(instance_names(instancer))).quats())


def uniform_quaternions(u: np.ndarray) -> np.ndarray:
    """Map (N, 3) uniforms to (N, 4) unit quaternions xyzw, uniform on SO(3) (Shoemake, Graphics Gems III, 1992)."""
    a, b = np.sqrt(1 - u[:, 0]), np.sqrt(u[:, 0])
    s, t = 2 * np.pi * u[:, 1], 2 * np.pi * u[:, 2]
    return np.stack([a * np.sin(s), a * np.cos(s), b * np.sin(t), b * np.cos(t)], axis=1)
