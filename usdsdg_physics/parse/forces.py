"""Read forces that act at every step: PhysxForceAPI."""

from collections.abc import Sequence

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.errors import warn_once
from usdsdg_physics.parse.attributes import value
from usdsdg_physics.parse.colliders import frame_from_prim
from usdsdg_physics.parse.units import Units, scaled_vector
from usdsdg_physics.scene.records import Force

# Of a stage's unit of force and torque; the solver's numbers have 32 bits.
_MOST = 1e18


def read_force(prim: Usd.Prim, owner: Usd.Prim | None, cache: UsdGeom.XformCache, units: Units) -> Force | None:
    """Read a prim with PhysxForceAPI: a rigid body, or a prim below one at whose origin the force acts.

    None, with a warning, where there is no body.
    """
    if owner is None:
        warn_once(
            f"{prim.GetPath()} has PhysxForceAPI but no rigid body at or above it, so its force acts on nothing. Apply "
            "the API to a rigid body, or to a prim below one."
        )
        return None
    given = {name: _push(prim, f"physxForce:{name}") for name in ("force", "torque")}
    if value(owner, "physics:kinematicEnabled", False) and any(map(any, given.values())):
        warn_once(
            f"{prim.GetPath()}: no force moves {owner.GetPath()}, which is kinematic. Disable "
            "physics:kinematicEnabled, or move the body from a script or by time samples."
        )
    acceleration = str(value(prim, "physxForce:mode", "acceleration")) == "acceleration"
    local = not value(prim, "physxForce:worldFrameEnabled", False)
    to_body = frame_from_prim(prim, owner, cache, units)
    axes = to_body[:3, :3] / np.linalg.norm(to_body[:3, :3], axis=1, keepdims=True) if local else np.eye(3)
    force = np.asarray(given["force"], np.float64) @ axes
    torque = np.asarray(given["torque"], np.float64) @ axes
    mass = 1.0 if acceleration else units.kilograms
    return Force(
        path=str(prim.GetPath()),
        body=str(owner.GetPath()),
        force=scaled_vector(force, mass * units.meters),
        # An angular acceleration has no unit of length.
        torque=scaled_vector(torque, 1.0 if acceleration else units.kilograms * units.meters**2),
        point=None if prim == owner else scaled_vector(to_body[3, :3], 1.0),
        acceleration=acceleration,
        local=local,
        enabled=bool(value(prim, "physxForce:forceEnabled", True)),
    )


def _push(prim: Usd.Prim, name: str) -> Sequence[float]:
    """Return a force or torque; zero, with a warning, of one that nothing can have."""
    found = value(prim, name, (0.0, 0.0, 0.0))
    if all(abs(component) <= _MOST for component in found):
        return found
    warn_once(f"{prim.GetPath()}: {name} is {tuple(found)}, so it counts as 0. Set numbers of at most {_MOST:.0e}.")
    return 0.0, 0.0, 0.0
