"""Velocities of rigid bodies: of the simulation where it does not write them to the stage, else of the stage."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Usd, UsdPhysics

from usdsdg.session import engines

_STILL = (0.0, 0.0, 0.0)


def velocities(prims: Sequence[Usd.Prim]) -> tuple[np.ndarray, np.ndarray]:
    """Return linear (N, 3) and angular velocities (N, 3) [rad/s], float32."""
    physics = engines.physics_if_made()
    if physics is not None and not physics.writes_velocities:
        paths = [str(prim.GetPath()) for prim in prims]
        if set(paths) <= set(physics.rigid_bodies):
            both = physics.velocities(paths).astype(np.float32)
            return both[:, :3], both[:, 3:]
    bodies = [UsdPhysics.RigidBodyAPI(prim) for prim in prims]
    linear = np.array([body.GetVelocityAttr().Get() or _STILL for body in bodies], np.float32)
    angular = np.array([body.GetAngularVelocityAttr().Get() or _STILL for body in bodies], np.float32)
    return linear.reshape(-1, 3), np.radians(angular).reshape(-1, 3)
