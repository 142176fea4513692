"""The 3D models of a BOP dataset: one for each shape that a class has, in millimeters in the object's frame."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.annotators.bounds.hulls import may_be_refined
from usdsdg.annotators.prims.labeled_survey import LabeledSurvey, SurveyedPrim
from usdsdg.annotators.prims.subset_setting import subsets_are_told_apart
from usdsdg.errors import warn_once
from usdsdg.stage.geometry.deforming import deformations
from usdsdg.stage.geometry.face_parts import read_face_parts
from usdsdg.stage.geometry.triangles import triangles_below
from usdsdg.stage.poses.transforms import as_array, inverse
from usdsdg.stage.time_code import first_time
from usdsdg.writers.formats.bop.shape_edits import ShapeEdits, own_path

# Further shapes of a class have its id plus as many of these.
VARIANT = 1000
# How many shapes one prim may have with the same triangles: more is a deformation, of which models have no end.
MOST_SHAPES = 8
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


# By how much a rotation of a 32-bit transform may be off.
_ROTATION = 1e-4


class Stretches:
    """What rigid poses cannot say of transforms, and so is in models: scale, shear, and mirroring.

    A mirrored transform can be split in several ways: a prim keeps its stretch for as long as that and a rotation give
    its transform.
    """

    def __init__(self) -> None:
        self._known: dict[str, np.ndarray] = {}  # by prim

    def note(self, path: str, matrix: np.ndarray) -> np.ndarray:
        """Return the stretch (3, 3) of a prim's transform (4, 4), and keep it from now on."""
        self._known[path] = stretch = self.split(path, matrix)[0]
        return stretch

    def split(self, path: str, matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return stretch and rotation (3, 3), of which the product is the linear part of a transform, row vectors."""
        linear, stretch = np.asarray(matrix, np.float64)[:3, :3], self._known.get(path)
        if stretch is not None and np.linalg.matrix_rank(stretch) == 3:
            rotation = np.linalg.solve(stretch, linear)
            nearest = nearest_rotation(rotation)
            if np.abs(rotation - nearest).max() <= _ROTATION:
                return stretch, nearest
        rotation = nearest_rotation(linear)
        return linear @ rotation.T, rotation


class Models:
    """Models by id. A survey of the stage at every frame decides on ids, so that they do not depend on what is seen."""

    def __init__(self) -> None:
        self.infos: dict[int, dict[str, float]] = {}  # the records of models_info of all models, by id
        self.names: dict[int, str] = {}  # of their classes
        self._shapes: dict[int, list[tuple[int, Model]]] = {}  # id and model of each shape, by class
        # By prim, then by class and scale; None: no triangles.
        self._known: dict[str, dict[tuple[int, bytes], int | None]] = {}
        self._prims: LabeledSurvey | None = None  # as it was surveyed last
        self._edits: ShapeEdits | None = None
        self._had: dict[str, set[int]] = {}  # ids that each prim had before its shape was edited
        self._deforming: set[str] = set()  # prims whose models stay what they are
        self._stretches = Stretches()
        self._now: dict[str, tuple[np.ndarray, int | None]] = {}  # stretch and id of each prim in this frame

    def forget_prims(self) -> None:
        """Forget which prim has which model, as for a new stage, where others may be at the same paths."""
        self._known.clear()
        self._edits = None
        self._had.clear()
        self._deforming.clear()
        self._now.clear()
        self._stretches = Stretches()

    def survey(
        self,
        prims: LabeledSurvey,
        numbers_of: Callable[[Sequence[dict[str, str]]], np.ndarray],
        millimeters: float,
        time: Usd.TimeCode,
    ) -> None:
        """Give ids to the models of all labeled prims of the stage, in its order.

        numbers_of: returns the numbers of classes, from 1, by their labels. millimeters: per stage unit. time: of the
            frame; what it shows otherwise than the stage does where it begins has ids after that.
        """
        self._prims = prims
        self._edits = self._edits or ShapeEdits(prims.stage)
        self._forget_edited(self._edits)
        self._now, at_first = {}, list(prims.read())
        known = {each.name: each for each in at_first}
        others = [each for each in prims.read_at(time) if not _is_as_in(each, known)]
        for found in (at_first, others):
            for each, number in zip(found, numbers_of([each.labels for each in found]).tolist(), strict=True):
                name = ",".join(each.labels.values())
                stretch = self._stretches.note(each.name, each.local_to_world)
                self._now[each.name] = stretch, self._find(each.name, number, name, stretch * millimeters)

    def model(self, obj_id: int) -> Model:
        """Return a model by its id."""
        return next(model for shapes in self._shapes.values() for each, model in shapes if each == obj_id)

    def place(self, path: str, number: int, name: str, matrix: np.ndarray, millimeters: float) -> Placed | None:
        """Return the object at a prim path as BOP has it; None, with a warning, if it has no triangles.

        number: of its class, from 1. matrix: local to world, row vectors. millimeters: per stage unit.
        """
        stretch, rotation = self._stretches.split(path, matrix)
        surveyed, obj_id = self._now.get(path, (None, None))
        # Its scale may be another where it is animated: the survey is of the beginning.
        if stretch is not surveyed:
            obj_id = self._find(path, number, name, stretch * millimeters)
        if obj_id is None:
            warn_once(f"BopWriter: {path} has no triangles, so it has no model and is left out.")
            return None
        return Placed(obj_id, rotation.T, np.asarray(matrix, np.float64)[3, :3])

    def _find(self, path: str, number: int, name: str, stretch: np.ndarray) -> int | None:
        """Return the id of a prim's model; None if it has no triangles."""
        models, key = self._known.setdefault(path, {}), (number, np.round(stretch, 3).tobytes())
        if key not in models:
            assert self._prims is not None, "models are found after a survey"
            model = model_of(self._prims, path, stretch)
            if model is not None:
                warn_of_deformation("BopWriter", self._prims, path)
            models[key] = None if model is None else self._id_of(number, name, model)
        return models[key]

    def _forget_edited(self, edits: ShapeEdits) -> None:
        """Forget the models of prims of which the shape was edited, except of those that deform all the time."""
        for path in edits.take([each for each in self._known if each not in self._deforming]):
            had = self._had.setdefault(path, set())
            had.update(each for each in self._known[path].values() if each is not None)
            if self._is_deforming(had):
                self._deforming.add(path)
                warn_once(
                    f"BopWriter: {path} deforms, and BOP's models are rigid: after {MOST_SHAPES} shapes its model "
                    "stays as it is, so that masks differ from it."
                )
            else:
                del self._known[path]

    def _is_deforming(self, ids: set[int]) -> bool:
        """Return whether many of these models have the same triangles, with points elsewhere."""
        counts = Counter(self.model(each).triangles.tobytes() for each in ids)
        return max(counts.values(), default=0) >= MOST_SHAPES

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
        self.infos[obj_id], self.names[obj_id] = measures(model.points), name
        return obj_id


def _is_as_in(prim: SurveyedPrim, known: Mapping[str, SurveyedPrim]) -> bool:
    """Return whether what is known by the name of a prim is the same."""
    other = known.get(prim.name)
    return (
        other is not None
        and prim.labels == other.labels
        and prim.local_to_world.tobytes() == other.local_to_world.tobytes()
    )


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


def model_of(prims: LabeledSurvey, path: str, stretch: np.ndarray) -> Model | None:
    """Return the triangles that are drawn of a labeled prim at first, without those of labeled prims inside of it.

    None if it has none. Where labels tell GeomSubsets apart, a subset has its faces of the mesh that it is in, and the
    mesh the others.

    stretch: linear map (3, 3), for row vectors, from the prim's frame to the model's.
    """
    prim = prims.stage.GetPrimAtPath(own_path(path))
    if not prim:
        return None
    time = first_time(prims.stage)
    to_local = inverse(as_array(UsdGeom.XformCache(time).GetLocalToWorldTransform(prim)))
    is_subset = prim.IsA(UsdGeom.Subset)
    faces_of = partial(_own_faces, prims, prim) if subsets_are_told_apart() else None
    left_out = None if is_subset else partial(_is_left_out, prims, prim)
    parts = triangles_below([prim.GetParent() if is_subset else prim], faces_of, left_out=left_out, time=time)
    owners = prims.owners_of([own_path(part.path) for part in parts])
    points, triangles, count = [], [], 0
    for part, owner in zip(parts, owners, strict=True):
        # A labeled material makes an object of its own of what is bound to it.
        if not is_subset and owner != prim.GetPath():
            continue
        _warn_of_refinement(prims.stage.GetPrimAtPath(own_path(part.path)), prim, time)
        with np.errstate(invalid="ignore"):
            matrix = part.to_world @ to_local
        if not np.isfinite(matrix).all():  # it is not drawn, and the renderer names it
            continue
        local = part.triangles.points @ matrix[:3, :3] + matrix[3, :3]
        points.append(local @ stretch)
        turned = np.linalg.det(matrix[:3, :3] @ stretch) < 0
        triangles.append((part.triangles.faces[:, ::-1] if turned else part.triangles.faces) + count)
        count += len(local)
    if not count:
        return None
    return Model(np.concatenate(points).astype(np.float32), np.concatenate(triangles).astype(np.int32))


def _is_left_out(prims: LabeledSurvey, owner: Usd.Prim, prim: Usd.Prim) -> bool:
    """Return whether a prim in a visible owner belongs to another object, or it and all below it is not drawn."""
    if (prim.IsA(UsdGeom.Gprim) or prim.IsA(UsdGeom.PointInstancer)) and not prims.is_drawn_for(prim):
        return True
    if prim == owner:
        return False
    is_hidden = prim.IsA(UsdGeom.Imageable) and prim.GetAttribute("visibility").Get() == UsdGeom.Tokens.invisible
    if is_hidden or prims.has_own_labels(prim):
        return True
    if any(map(prim.IsA, (UsdGeom.Curves, UsdGeom.Points, UsdGeom.NurbsPatch))):
        warn_once(
            f"{prim.GetPath()}: no faces are read of {prim.GetTypeName()}, so that the model of {owner.GetPath()} is "
            "without it, and its masks are not. Convert it to a Mesh, or give it a label of its own."
        )
    return False


def _warn_of_refinement(part: Usd.Prim, owner: Usd.Prim, time: Usd.TimeCode) -> None:
    if part.IsA(UsdGeom.Mesh) and may_be_refined(UsdGeom.Mesh(part), time):
        warn_once(
            f"{part.GetPath()}: pictures refine its faces, and the model of {owner.GetPath()} has them unrefined, so "
            "that masks and depths differ from it. Author the refined faces with the subdivisionScheme none, or remove "
            "creases, corners and refinementEnableOverride."
        )


def warn_of_deformation(writer: str, prims: LabeledSurvey, path: str) -> None:
    """Warn once, in the name of a writer, where a labeled prim deforms over time, of which its model has no part."""
    prim = prims.stage.GetPrimAtPath(own_path(path))
    deformation = next(deformations(prim, prims.has_own_labels), None)
    if deformation is not None:
        warn_once(
            f"{writer}: {path} deforms ({deformation}), and its model is rigid: it has the shape of the "
            "stage's first time, without skins, so that masks differ from it. Label parts that are rigid, or leave "
            "the prim unlabeled."
        )


def _own_faces(prims: LabeledSurvey, owner: Usd.Prim, mesh: Usd.Prim) -> np.ndarray | None:
    """Return which faces of a mesh belong to a labeled prim, (F,) bool, and not to a labeled subset; None for all."""
    subsets, of_face = read_face_parts(mesh, first_time(prims.stage))
    if owner.IsA(UsdGeom.Subset):
        return np.array([*(path == owner.GetPath() for path in subsets), False])[of_face]
    if not subsets:
        return None
    own = [prims.stage.GetPrimAtPath(path) for path in subsets]
    return np.array([*(not prims.has_own_labels(subset) for subset in own), True])[of_face]


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
