"""What bodies weigh, and how the mass is spread, as users read it."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class BodyMasses:
    """Mass properties of bodies, a row each, in units of the stage.

    A body's frame has the origin and the axes of its prim in the world, and no scale.
    """

    mass: np.ndarray  # (N,)
    center: np.ndarray  # (N, 3) center of mass, body frame
    inertia: np.ndarray  # (N, 3, 3) mass · length², about the center of mass, axes of the body frame
