"""Transforms of prims as matrices, and the stage's up axis and length unit."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.errors import DegenerateFrame, warn_once

Array = NDArray[np.float64]

# A matrix with a smaller determinant counts as singular.
SINGULAR = 1e-30

# Lengths of units [m]: from a tenth of an atom to a light year.
_SHORTEST, _LONGEST = 1e-11, 1e16


def local_to_world(prim: Usd.Prim, time: Usd.TimeCode = Usd.TimeCode.Default()) -> Gf.Matrix4d:  # noqa: B008
    """Return the matrix from the prim's own space to the world [stage units]; identity without transforms."""
    return UsdGeom.XformCache(time).GetLocalToWorldTransform(prim)


def inverse(matrix: np.ndarray) -> np.ndarray:
    """Return the inverse (4, 4) of an affine matrix of row vectors, also of one that flattens, as a scale of 0 does.

    That one has many: points which it takes to a place lie at this place again.
    """
    try:
        return np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        found = np.eye(4)
        found[:3, :3] = np.linalg.pinv(matrix[:3, :3])
        found[3, :3] = -matrix[3, :3] @ found[:3, :3]
        return found


def world_to_local(prim: Usd.Prim, time: Usd.TimeCode = Usd.TimeCode.Default()) -> Gf.Matrix4d:  # noqa: B008
    """Return the inverse of `local_to_world`.

    Raises:
        DegenerateFrame: the prim or an ancestor is scaled to zero.
    """
    matrix = local_to_world(prim, time)
    if abs(matrix.GetDeterminant()) < SINGULAR:
        raise DegenerateFrame(f"{prim.GetPath()} has no inverse transform: it or an ancestor has a scale of zero")
    return matrix.GetInverse()


def parent_to_world(prim: Usd.Prim, time: Usd.TimeCode = Usd.TimeCode.Default()) -> Gf.Matrix4d:  # noqa: B008
    """Return the matrix from the space of the prim's local matrix to the world; identity if it resets the stack."""
    return parent_in(UsdGeom.XformCache(time), prim)


def parent_in(cache: UsdGeom.XformCache, prim: Usd.Prim) -> Gf.Matrix4d:
    """Return `parent_to_world` at the time of a cache, which keeps the matrices of what is above other prims, too."""
    if UsdGeom.Xformable(prim).GetResetXformStack():
        return Gf.Matrix4d(1)
    return cache.GetParentToWorldTransform(prim)


def parents_to_world(prims: Sequence[Usd.Prim], time: Usd.TimeCode = Usd.TimeCode.Default()) -> Array:  # noqa: B008
    """Return `parent_to_world` of each prim (N, 4, 4); siblings are computed once."""
    cache = UsdGeom.XformCache(time)
    known: dict[Sdf.Path, Array] = {}
    matrices = []
    for prim in prims:
        if UsdGeom.Xformable(prim).GetResetXformStack():
            matrices.append(np.eye(4))
            continue
        path = prim.GetPath().GetParentPath()
        if path not in known:
            known[path] = as_array(cache.GetParentToWorldTransform(prim))
        matrices.append(known[path])
    return np.stack(matrices)


def inverse_of_parent(prim: Usd.Prim, time: Usd.TimeCode = Usd.TimeCode.Default()) -> Gf.Matrix4d:  # noqa: B008
    """Return the inverse of `parent_to_world`.

    Raises:
        DegenerateFrame: an ancestor is scaled to zero.
    """
    matrix = parent_to_world(prim, time)
    if abs(matrix.GetDeterminant()) < SINGULAR:
        raise _flattened(prim)
    return matrix.GetInverse()


def inverses_of_parents(prims: Sequence[Usd.Prim]) -> Array:
    """Return the inverses (N, 4, 4) of `parents_to_world`.

    Raises:
        DegenerateFrame: an ancestor of a prim is scaled to zero.
    """
    matrices = parents_to_world(prims)
    singular = np.abs(np.linalg.det(matrices)) < SINGULAR
    if singular.any():
        raise _flattened(prims[int(np.argmax(singular))])
    return np.asarray(np.linalg.inv(matrices), np.float64)


def _flattened(prim: Usd.Prim) -> DegenerateFrame:
    return DegenerateFrame(f"{prim.GetPath()} cannot be placed: an ancestor is scaled to zero")


def local_matrices(prims: Sequence[Usd.Prim], time: Usd.TimeCode = Usd.TimeCode.Default()) -> Array:  # noqa: B008
    """Return the matrices (N, 4, 4) from each prim's own space to its parent's."""
    cache = UsdGeom.XformCache(time)
    return np.stack([as_array(cache.GetLocalTransformation(prim)[0]) for prim in prims])


def product_of_ops(matrices: Iterable[Gf.Matrix4d]) -> Gf.Matrix4d:
    """Return the matrix of xform ops from those of each, in the order of xformOpOrder: the last applies first."""
    product = Gf.Matrix4d(1.0)
    for matrix in matrices:
        product = matrix * product
    return product


def as_array(matrix: Gf.Matrix4d) -> Array:
    """Copy a matrix to a float64 array (4, 4), row vectors as in USD."""
    return np.array(matrix, np.float64)


def meters_per_unit(stage: Usd.Stage) -> float:
    """Return the length of one stage unit [m]; 1, with a warning, if metersPerUnit is not the length of a unit."""
    value = float(UsdGeom.GetStageMetersPerUnit(stage))
    if _SHORTEST <= value <= _LONGEST:
        return value
    warn_once(
        f"{stage.GetRootLayer().identifier}: metersPerUnit {value} is not a length; 1 is used. Author a value > 0, of "
        f"{_SHORTEST:g} to {_LONGEST:g}."
    )
    return 1.0


def up_axis(stage: Usd.Stage) -> str:
    """Return the stage's up axis, 'Y' or 'Z'; with a warning, 'Z' for "z" and else 'Y' if upAxis is neither."""
    value = str(UsdGeom.GetStageUpAxis(stage))
    if value in ("Y", "Z"):
        return value
    axis = "Z" if value == "z" else "Y"
    warn_once(
        f"{stage.GetRootLayer().identifier}: upAxis {value!r} is neither 'Y' nor 'Z'; {axis!r} is used. Author one."
    )
    return axis


def up_vector(stage: Usd.Stage) -> tuple[float, float, float]:
    """Return the unit vector of the stage's up axis."""
    return (0.0, 0.0, 1.0) if up_axis(stage) == "Z" else (0.0, 1.0, 0.0)
