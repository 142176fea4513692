"""Small bodies, which need shorter substeps than others, but only where they may touch something."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from usdsdg_physics.scene.extents import length
from usdsdg_physics.scene.records import Scene
from usdsdg_physics.world.substeps.shape_bounds import ShapeBounds

if TYPE_CHECKING:
    import newton

# The solver leaves errors of the order of the way that gravity moves a body in a substep: what is not this many times
# as large, such as a stack of 2 cm cubes at 1/120 s, or of 2 mm ones at 1/240 s, does not stand.
MIN_SIZE_PER_FALL = 40.0
MAX_SIZE_FACTOR = 4


def size_factors(sizes: np.ndarray, fall: float, rate: float) -> np.ndarray:
    """Return how many substeps bodies of these sizes (N,) [m] need in place of one, where there are `rate` a second.

    Args:
        sizes: 0 for bodies that gravity does not move.
        fall: acceleration of gravity [m/s²].
    """
    factors, factor = np.ones(len(sizes), int), 1
    while factor < MAX_SIZE_FACTOR:
        is_small = fall / (factor * rate) ** 2 * MIN_SIZE_PER_FALL > sizes
        factor *= 2
        factors[(sizes > 0.0) & is_small] = factor
    return factors


class SmallBodies:
    """Which small bodies may touch something during a step, by spheres around shapes that move and boxes of others.

    Those that are held at rest need no short substeps, unless one of them that was held had to be let go in a longer
    one.
    """

    def __init__(self, scene: Scene, model: newton.Model, rate: float) -> None:
        """`rate` is that of the substeps [1/s] of bodies that are not small."""
        self._model, self._rate = model, rate
        self._bounds: ShapeBounds | None = None  # once there are small bodies
        sizes = {path: 0.0 for path, body in scene.bodies.items() if not body.kinematic}
        for collider in scene.colliders.values():
            if collider.body in sizes:
                sizes[collider.body] = max(sizes[collider.body], length(collider.shape))
        # Bodies that close loops of joints have no prims, and come last.
        self._sizes = np.zeros(model.body_count)
        self._sizes[: len(scene.bodies)] = [sizes.get(path, 0.0) for path in scene.bodies]
        self._restless = np.zeros(len(self._sizes), bool)
        self._held: np.ndarray = np.zeros(len(self._sizes), bool)  # those that the latest step left out
        self._fall = 0.0
        enabled = np.array([body.gravity for body in scene.bodies.values()], bool)
        self.set_gravity(np.asarray(scene.gravity, np.float64), enabled)

    def set_gravity(self, gravity: np.ndarray, enabled: np.ndarray) -> None:
        """Set the scene's gravity (3,) [m/s²], and on which bodies it acts (N,): both decide what is small.

        The strongest so far counts, since a settled start begins with steps without gravity.
        """
        self._fall = max(self._fall, float(np.linalg.norm(gravity)))
        acts = np.pad(enabled, (0, len(self._sizes) - len(enabled)))
        self._factors = size_factors(np.where(acts, self._sizes, 0.0), self._fall, self._rate)
        if self and self._bounds is None:
            self._bounds = ShapeBounds(self._model)

    def __bool__(self) -> bool:
        return bool((self._factors > 1).any())

    @property
    def most(self) -> int:
        """The most substeps in place of one that a body may need."""
        return int(self._factors.max(initial=1))

    def update_static(self) -> None:
        """Read where static colliders are."""
        if self._bounds is not None:
            self._bounds.update_static()

    def forget_rest(self) -> None:
        """Bodies are let go for another reason than their own motion."""
        self._held[:] = False

    def factor(self, dt: float, poses: np.ndarray, velocities: np.ndarray, held: np.ndarray) -> int:
        """Return how many substeps in place of one a step of `dt` seconds needs, with poses and velocities of all.

        `held` (N,) marks the bodies that are held at rest.
        """
        held = np.pad(held, (0, len(self._factors) - len(held)))
        self._restless |= self._held & ~held
        self._held = held & ~self._restless & (self._factors > 1)
        bounds = self._bounds
        assert bounds is not None
        body, centers = bounds.body, bounds.centers(poses.astype(np.float64))
        speed = np.linalg.norm(velocities[:, :3], axis=1)[body] + self._fall * dt
        # Centers of mass may be off the bodies' origins by as much as their shapes.
        speed += 2.0 * bounds.arm * np.linalg.norm(velocities[:, 3:], axis=1)[body]
        reach = bounds.radius + speed * dt
        needed = np.where(self._held, 1, self._factors)[body]
        factor = 1
        for i in np.argsort(-needed, kind="stable"):
            if needed[i] <= factor:
                break
            apart = np.linalg.norm(centers - centers[i], axis=1) > reach + reach[i]
            if not (apart | (body == body[i])).all() or _near_static(bounds, centers[i], reach[i]):
                factor = int(needed[i])
        return factor


def _near_static(bounds: ShapeBounds, center: np.ndarray, reach: float) -> bool:
    middle, half = bounds.static_boxes
    return bool((np.abs(center - middle) <= half + reach).all(axis=1).any())
