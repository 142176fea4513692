"""Random positions in, on and between spheres: nodes that scripts add with `rep.utils.create_node`."""

from typing import Any

import numpy as np

from usdsdg.errors import ArgumentError
from usdsdg.graph.actions import action
from usdsdg.graph.node import Node
from usdsdg.graph.sampling import get_global_seed, uniforms
from usdsdg.modify.prims import target_prims
from usdsdg.stage.poses.pose_batch import author_poses


@action("OgnSampleInSphere", "radius")
def _in_sphere(node: Node, execution: int) -> None:
    _place(node, execution, 0.0, _radius(node, "radius", 1.0))


@action("OgnSampleOnSphere", "radius")
def _on_sphere(node: Node, execution: int) -> None:
    radius = _radius(node, "radius", 1.0)
    _place(node, execution, radius, radius)


@action("OgnSampleBetweenSpheres", "radius1", "radius2")
def _between_spheres(node: Node, execution: int) -> None:
    one, other = _radius(node, "radius1", 0.5), _radius(node, "radius2", 1.0)
    _place(node, execution, min(one, other), max(one, other))


def _radius(node: Node, name: str, default: float) -> float:
    """Return a radius [stage units].

    Raises:
        ArgumentError: it is not a number, or negative.
    """
    given: Any = node.inputs.get(name, default)
    try:
        radius = float(given)
    except (TypeError, ValueError):
        radius = -1.0
    if not (np.isfinite(radius) and radius >= 0.0):
        raise ArgumentError(f"{name} is {given!r}; expected a number, 0 or more")
    return radius


def _place(node: Node, execution: int, inner: float, outer: float) -> None:
    """Set the local translation of each prim, uniformly by volume between two radii around the origin."""
    prims = target_prims(node)
    if prims:
        u = uniforms(get_global_seed(), node.key, execution, node.prims, 3)
        author_poses(prims, translate=points_between(u, inner, outer))


def points_between(u: np.ndarray, inner: float, outer: float) -> np.ndarray:
    """Map (N, 3) uniforms to points (N, 3), uniform by volume between two radii, or by area where they are equal."""
    azimuth, z = 2 * np.pi * u[:, 0], 2 * u[:, 1] - 1
    radius = np.cbrt(inner**3 + u[:, 2] * (outer**3 - inner**3))
    across = radius * np.sqrt(1 - z * z)
    return np.stack([across * np.cos(azimuth), across * np.sin(azimuth), radius * z], axis=1)
