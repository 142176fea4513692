"""Fast bodies with continuous collision detection: substeps so short that they pass through nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.scene.extents import half_thickness
from usdsdg_physics.scene.records import Scene
from usdsdg_physics.world.substeps.shape_bounds import ShapeBounds

if TYPE_CHECKING:
    import newton

# Of a step: enough for a ball of 1 cm that flies at 75 m/s, where there are 60 steps a second.
MAX_SUBSTEPS = 256


class FastBodies:
    """The bodies with physxRigidBody:enableCCD, and whether something is on their way during a step.

    Contacts are found where shapes are at the begin of a substep. What travels its half thickness at most in one is
    seen in front of a wall before its middle is inside; what travels farther may be in front of it, and then behind it.
    """

    def __init__(self, scene: Scene, model: newton.Model) -> None:
        bodies = list(scene.bodies.values())
        half = dict.fromkeys(scene.bodies, np.inf)
        for collider in scene.colliders.values():
            if collider.body and not collider.trigger:
                half[collider.body] = min(half[collider.body], half_thickness(collider.shape))
        # Infinite of all other bodies; those that close loops of joints have no prims, and come last.
        self._half_thickness = np.full(model.body_count, np.inf)
        self._half_thickness[: len(bodies)] = [
            half[body.path] if body.continuous and not body.kinematic else np.inf for body in bodies
        ]
        self._any = bool(np.isfinite(self._half_thickness).any())
        if self._any:
            self._bounds = ShapeBounds(model)

    def __bool__(self) -> bool:
        return self._any

    def update_static(self) -> None:
        """Read where static colliders are."""
        if self._any:
            self._bounds.update_static()

    def substeps(self, dt: float, poses: np.ndarray, velocities: np.ndarray, count: int) -> int:
        """Return how many substeps a step of `dt` seconds needs, `count` or that times a power of two.

        Args:
            poses: (N, 7) of all bodies.
            velocities: (N, 6) likewise; those of kinematic bodies on the way to their targets.
        """
        travel = np.linalg.norm(velocities[:, :3], axis=1).astype(np.float64) * dt
        fast = travel > count * self._half_thickness
        if not fast.any():
            return count
        bounds = self._bounds
        move = velocities[bounds.body, :3].astype(np.float64) * dt
        # Boxes around what each sphere passes through.
        middle = bounds.centers(poses.astype(np.float64)) + move / 2.0
        half = np.abs(move) / 2.0 + bounds.radius[:, None]
        needed = 0.0
        for shape in np.flatnonzero(fast[bounds.body]):
            body, way = bounds.body[shape], 0.0
            at, size = bounds.static_boxes
            # A plane has no other side.
            if ((np.abs(at - middle[shape]) <= size + half[shape]).all(axis=1) & ~bounds.endless).any():
                way = travel[body]
            met = (np.abs(middle - middle[shape]) <= half + half[shape]).all(axis=1) & (bounds.body != body)
            if met.any():
                way = travel[body] + travel[bounds.body[met]].max()
            needed = max(needed, way / self._half_thickness[body])
        while count < needed and 2 * count <= MAX_SUBSTEPS:
            count *= 2
        return count
