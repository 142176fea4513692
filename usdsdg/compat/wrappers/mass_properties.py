"""Centers of mass and inertias of rigid bodies that physics simulates, as float32 arrays with a row per prim.

Positions are in the body's frame, which has the axes of its prim in the world and no scale [stage units]. Quaternions
are (w, x, y, z). What is set is authored in UsdPhysics.MassAPI. As in PhysX it acts from the next step until physics
stops, which puts back what the stage had.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations
from typing import TYPE_CHECKING

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from usdsdg.compat.wrappers import poses, rotations
from usdsdg.compat.wrappers.runtime_values import keep_until_stop
from usdsdg.errors import BadValue
from usdsdg.session import engines
from usdsdg.stage.poses.transforms import as_array

if TYPE_CHECKING:
    from usdsdg_physics.scene.body_masses import BodyMasses

# Share of the largest moment below which products of inertia are rounding.
_ROUNDING = 1e-6


def centers(prims: Sequence[Usd.Prim]) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions (N, 3) of the centers of mass, and the orientations (N, 4) of the principal axes.

    Raises:
        PhysicsError: physics does not play, or a prim is no rigid body.
    """
    found = _simulated(prims)
    axes = [_axes(prim, inertia) for prim, inertia in zip(prims, found.inertia)]
    return found.center.astype(np.float32), np.array(axes, np.float32).reshape(-1, 4)


def inertias(prims: Sequence[Usd.Prim], *, inverse: bool = False) -> np.ndarray:
    """Return the inertias (N, 9) about the centers of mass, or their inverses, along the bodies' own axes.

    Raises:
        PhysicsError: physics does not play, or a prim is no rigid body.
    """
    found = _simulated(prims).inertia
    return (np.linalg.inv(found) if inverse else found).reshape(-1, 9).astype(np.float32)


def set_centers(prims: Sequence[Usd.Prim], positions: np.ndarray | None, orientations: np.ndarray | None) -> None:
    """Author centers of mass (N, 3) and principal axes (N, 4); None keeps what is there.

    As in PhysX the moments of inertia about the center and the principal axes stay what they are.

    Raises:
        PhysicsError: physics does not play, or a prim is no rigid body.
    """
    found, turns = _simulated(prims), centers(prims)[1]
    for row, prim in enumerate(prims):
        axes = rotations.matrix_of_quat(turns[row])
        moments = np.diagonal(axes.T @ found.inertia[row] @ axes)
        _author_inertia(prim, moments, turns[row] if orientations is None else orientations[row])
        if positions is not None:
            keep_until_stop([prim], [UsdPhysics.Tokens.physicsCenterOfMass])
            center = _in_prim(prim, positions[row])
            _mass_api(prim).CreateCenterOfMassAttr().Set(Gf.Vec3f(*center.tolist()))


def set_inertias(prims: Sequence[Usd.Prim], values: np.ndarray) -> None:
    """Author inertias (N, 9) about the centers of mass, along the bodies' own axes.

    Raises:
        BadValue: an inertia has a principal moment that is not positive.
    """
    matrices = np.asarray(values, np.float64).reshape(-1, 3, 3)
    for prim, matrix in zip(prims, matrices, strict=True):
        moments, turn = principal(matrix)
        if not (moments > 0.0).all():
            raise BadValue(f"{prim.GetPath()}: an inertia with the principal moments {moments} is not positive")
        _author_inertia(prim, moments, turn)


def principal(inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the principal moments (3,) of an inertia (3, 3), and the rotation (4,) to their axes nearest to none."""
    symmetric = (inertia + inertia.T) / 2.0
    diagonal = np.diagonal(symmetric)
    if np.abs(symmetric - np.diag(diagonal)).max() <= _ROUNDING * np.abs(diagonal).max():
        return diagonal.copy(), np.array([1.0, 0.0, 0.0, 0.0])
    moments, axes = np.linalg.eigh(symmetric)  # axes are columns
    order = list(max(permutations(range(3)), key=lambda each: np.abs(np.diagonal(axes[:, each])).sum()))
    moments, axes = moments[order], axes[:, order]
    axes = axes * np.where(np.diagonal(axes) < 0.0, -1.0, 1.0)
    if np.linalg.det(axes) < 0.0:
        axes[:, np.argmin(np.diagonal(axes))] *= -1.0
    return moments, rotations.quat_of_matrix(axes)


def num_shapes(prims: Sequence[Usd.Prim]) -> int:
    """Return how many colliders the body has that has most; a collider of several convex parts counts once."""
    return max((_num_shapes(prim) for prim in prims), default=0)


def _num_shapes(body: Usd.Prim) -> int:
    """Return the number of colliders of a body, without those of bodies below it."""
    count, below = 0, iter(Usd.PrimRange(body, Usd.TraverseInstanceProxies()))
    for prim in below:
        if prim != body and prim.HasAPI(UsdPhysics.RigidBodyAPI):
            below.PruneChildren()
        elif prim.HasAPI(UsdPhysics.CollisionAPI):
            count += 1
    return count


def _simulated(prims: Sequence[Usd.Prim]) -> BodyMasses:
    return engines.physics().mass_properties([str(prim.GetPath()) for prim in prims])


def _axes(prim: Usd.Prim, inertia: np.ndarray) -> np.ndarray:
    """Return the rotation (4,) to the principal axes: the authored one where it counts."""
    api = UsdPhysics.MassAPI(prim)
    if prim.HasAPI(UsdPhysics.MassAPI) and any(api.GetDiagonalInertiaAttr().Get()):
        turn = api.GetPrincipalAxesAttr().Get()
        if turn.GetLength() > 0.0:
            return np.array([turn.GetReal(), *turn.GetImaginary()]) / turn.GetLength()
    return principal(inertia)[1]


def _in_prim(prim: Usd.Prim, position: np.ndarray) -> np.ndarray:
    """Return a position of a body's frame in the prim's own space, which scales."""
    offset = rotations.matrix_of_quat(poses.world_poses([prim])[1][0]) @ position
    to_world = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
    return offset @ np.linalg.inv(as_array(to_world)[:3, :3])


def _author_inertia(prim: Usd.Prim, moments: np.ndarray, turn: np.ndarray) -> None:
    keep_until_stop([prim], [UsdPhysics.Tokens.physicsDiagonalInertia, UsdPhysics.Tokens.physicsPrincipalAxes])
    api, (w, x, y, z) = _mass_api(prim), (float(part) for part in turn)
    api.CreateDiagonalInertiaAttr().Set(Gf.Vec3f(*moments.tolist()))
    api.CreatePrincipalAxesAttr().Set(Gf.Quatf(w, x, y, z))


def _mass_api(prim: Usd.Prim) -> UsdPhysics.MassAPI:
    return UsdPhysics.MassAPI.Apply(prim)
