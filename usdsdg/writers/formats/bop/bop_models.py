"""The 3D models of a BOP dataset: one for each shape that a class has, in millimeters in the object's frame."""

from __future__ import annotations

import contextlib
import re
from typing import NamedTuple

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.errors import warn_once
from usdsdg.stage.geometry.triangles import triangles_below
from usdsdg.stage.poses.transforms import as_array
from usdsdg.stage.semantics.labels import get_labels

# Further shapes of a class have its id plus as many of these.
VARIANT = 1000
# Coordinates of equal shapes agree to this [mm]; transforms are 32-bit in payloads.
PRECISION = 0.01


class Placed(NamedTuple):
    """An object as BOP has it: a model, and a rigid transform from its frame to the world's axes."""

    obj_id: int
    rotation: np.ndarray  # (3, 3) for column vectors, model to world
    position: np.ndarray  # (3,) stage units


class Model(NamedTuple):
    """Triangles of one object, in millimeters where BopWriter has it."""

    points: np.ndarray  # (N, 3) float32
    triangles: np.ndarray  # (T, 3) int32


class Models:
    """Models by id, in the order in which they are needed; `new` lists those that are not written yet."""

    def __init__(self) -> None:
        self.new: list[tuple[int, Model]] = []
        self._shapes: dict[int, list[tuple[int, Model]]] = {}  # id and model of each shape, by class
        self._known: dict[tuple[str, int, bytes], int] = {}  # by prim, class and scale

    def place(
        self, stage: Usd.Stage, path: str, number: int, name: str, matrix: np.ndarray, millimeters: float
    ) -> Placed | None:
        """Return the object at a prim path as BOP has it; None, with a warning, if it has no triangles.

        number: of its class, from 1. matrix: local to world, row vectors. millimeters: per stage unit.
        """
        linear = np.asarray(matrix, np.float64)[:3, :3]
        rotation = nearest_rotation(linear)
        # What a rigid pose cannot say is in the model: scale, shear, and mirroring.
        stretch = linear @ rotation.T
        key = (path, number, np.round(stretch * millimeters, 3).tobytes())
        if key not in self._known:
            model = model_of(stage, path, stretch * millimeters)
            if model is None:
                warn_once(f"BopWriter: {path} has no triangles, so it has no model and is left out.")
                return None
            self._known[key] = self._id_of(number, name, model)
        return Placed(self._known[key], rotation.T, np.asarray(matrix, np.float64)[3, :3])

    def _id_of(self, number: int, name: str, model: Model) -> int:
        shapes = self._shapes.setdefault(number, [])
        for obj_id, known in shapes:
            if _is_same(known, model):
                return obj_id
        if shapes:
            warn_once(
                f"BopWriter: objects of the class {name!r} differ in shape or scale, and BOP's models are rigid: "
                f"further shapes are models of their own, {number + VARIANT}, {number + 2 * VARIANT}, ..."
            )
        obj_id = number + len(shapes) * VARIANT
        shapes.append((obj_id, model))
        self.new.append((obj_id, model))
        return obj_id


def _is_same(a: Model, b: Model) -> bool:
    return np.array_equal(a.triangles, b.triangles) and np.allclose(a.points, b.points, rtol=0.0, atol=PRECISION)


def ply(model: Model) -> bytes:
    """Return a model as a binary PLY file."""
    import trimesh

    mesh = trimesh.Trimesh(model.points, model.triangles, process=False)
    return mesh.export(file_type="ply", vertex_normal=True)  # pyright: ignore[reportReturnType]


def measures(points: np.ndarray) -> dict[str, float]:
    """Return the record of models_info of points (N, 3): diameter, and the box that holds them [mm]."""
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    named = {f"min_{axis}": value for axis, value in zip("xyz", low)} | {f"size_{a}": v for a, v in zip("xyz", size)}
    return {"diameter": _diameter(points), **{name: float(value) for name, value in named.items()}}


def model_of(stage: Usd.Stage, path: str, stretch: np.ndarray) -> Model | None:
    """Return the triangles of a labeled prim without those of labeled prims inside of it; None if it has none.

    stretch: linear map (3, 3), for row vectors, from the prim's frame to the model's.
    """
    prim = stage.GetPrimAtPath(re.sub(r"(\[\d+\])+$", "", path))
    if not prim:
        return None
    to_local = np.linalg.inv(as_array(UsdGeom.XformCache().GetLocalToWorldTransform(prim)))
    inner = [
        each.GetPath()
        for each in Usd.PrimRange(prim, Usd.TraverseInstanceProxies())
        if each != prim and get_labels(each)
    ]
    points, triangles, count = [], [], 0
    for part in triangles_below([prim]):
        own = stage.GetPrimAtPath(part.path.split("[", 1)[0])
        if any(own.GetPath().HasPrefix(each) for each in inner) or UsdGeom.Imageable(own).ComputePurpose() == "guide":
            continue
        matrix = part.to_world @ to_local
        local = part.triangles.points @ matrix[:3, :3] + matrix[3, :3]
        points.append(local @ stretch)
        turned = np.linalg.det(matrix[:3, :3] @ stretch) < 0
        triangles.append((part.triangles.faces[:, ::-1] if turned else part.triangles.faces) + count)
        count += len(local)
    if not count:
        return None
    return Model(np.concatenate(points).astype(np.float32), np.concatenate(triangles).astype(np.int32))


def nearest_rotation(linear: np.ndarray) -> np.ndarray:
    """Return the rotation (3, 3), for row vectors, that is nearest to a linear map."""
    u, _, vt = np.linalg.svd(linear)
    rotation = u @ vt
    if np.linalg.det(rotation) < 0:
        rotation = u @ np.diag((1.0, 1.0, -1.0)) @ vt
    return rotation


def _diameter(points: np.ndarray) -> float:
    """Return the largest distance of two points."""
    from scipy.spatial import ConvexHull, QhullError
    from scipy.spatial.distance import pdist

    corners = np.unique(points.astype(np.float64), axis=0)
    with contextlib.suppress(QhullError):  # flat
        corners = corners[ConvexHull(corners).vertices]
    return float(pdist(corners).max()) if len(corners) > 1 else 0.0
