"""The models of the classes, as points in meters: `points.xyz`."""

import io
from collections.abc import Mapping

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.annotators.prims.labeled_survey import LabeledSurvey
from usdsdg.errors import warn_once
from usdsdg.stage.poses.transforms import as_array, inverse, local_to_world, meters_per_unit
from usdsdg.writers.formats.bop.bop_models import Stretches, model_of, warn_of_deformation
from usdsdg.writers.formats.bop.shape_edits import ShapeEdits
from usdsdg.writers.formats.ycb_video.ycb_pictures import class_of

_SAME = 1e-4  # meters by which points of equal shapes may differ; transforms are 32-bit in payloads


class Models:
    """The first shape of each class on the stage, seen or not; `new` has those that were seen and are to be written."""

    def __init__(self) -> None:
        self.new: dict[str, np.ndarray] = {}
        self._seen: set[str] = set()
        self._stretches = Stretches()
        self._points: dict[str, np.ndarray | None] = {}
        self._compared: set[tuple[str, str, bytes]] = set()
        self._prims: LabeledSurvey | None = None  # as it was surveyed last
        self._edits: ShapeEdits | None = None

    def forget_prims(self) -> None:
        """Forget which prims were compared, as for a new stage, where others may be at the same paths."""
        self._compared.clear()
        self._edits = None
        self._stretches = Stretches()

    def survey(self, prims: LabeledSurvey, indices: Mapping[str, int]) -> None:
        """Note the shapes of all labeled prims, in the order of the stage. indices: of the classes that have models."""
        meters = meters_per_unit(prims.stage)
        self._prims = prims
        self._edits = self._edits or ShapeEdits(prims.stage)
        if edited := set(self._edits.take({path for path, _, _ in self._compared})):
            self._compared = {each for each in self._compared if each[0] not in edited}
        for each in prims.read():
            name = class_of(each.labels, indices)
            if name in indices:
                self._note(each.name, name, self._stretches.note(each.name, each.local_to_world) * meters)

    def place(self, path: str, name: str, matrix: np.ndarray, meters: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the rotation (3, 3), for column vectors, and position (3,) [stage units] of an object in the world.

        matrix: local to world, row vectors. meters: per stage unit. Scale, shear and mirroring are in the model.
        """
        stretch, rotation = self._stretches.split(path, matrix)
        self._note(path, name, stretch * meters)
        if name not in self._seen:
            self._seen.add(name)
            if (points := self._points[name]) is not None:
                self.new[name] = points
        return rotation.T, np.asarray(matrix, np.float64)[3, :3]

    def _note(self, path: str, name: str, stretch: np.ndarray) -> None:
        key = (path, name, np.round(stretch, 6).tobytes())
        if key not in self._compared:
            self._compared.add(key)
            self._compare(path, name, stretch)

    def _compare(self, path: str, name: str, stretch: np.ndarray) -> None:
        assert self._prims is not None, "models are compared after a survey"
        model = model_of(self._prims, path, stretch)
        points = None if model is None else model.points
        if model is not None:
            warn_of_deformation("YCBVideoWriter", self._prims, path)
        if name not in self._points:
            self._points[name] = points
        elif not _equal(self._points[name], points):
            warn_once(
                f"YCBVideoWriter: {path} differs in shape or scale from the first object of the class {name!r}, and "
                "YCB-Video has one model of a class: give it a class of its own."
            )


def _equal(one: np.ndarray | None, other: np.ndarray | None) -> bool:
    if one is None or other is None:
        return one is other
    return one.shape == other.shape and bool(np.abs(one - other).max(initial=0.0) <= _SAME)


def points_file(points: np.ndarray) -> bytes:
    """Return a `points.xyz` of points (N, 3): x y z in each line, with six digits after the point."""
    buffer = io.BytesIO()
    np.savetxt(buffer, points, fmt="%.6f", delimiter=" ", newline="\n")
    return buffer.getvalue()


def vertices_in(mesh: UsdGeom.Mesh | Usd.Prim, frame: Usd.Prim) -> np.ndarray:
    """Return the vertices (N, 3) of a mesh in the frame of another prim [m]."""
    prim = mesh.GetPrim()
    matrix = as_array(local_to_world(prim)) @ inverse(as_array(local_to_world(frame)))
    points = np.array(UsdGeom.PointBased(prim).GetPointsAttr().Get() or [], np.float64).reshape(-1, 3)
    return (points @ matrix[:3, :3] + matrix[3, :3]) * meters_per_unit(prim.GetStage())
