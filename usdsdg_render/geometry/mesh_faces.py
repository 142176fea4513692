"""The faces of a mesh: which of them can be drawn, and their material slots."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from usdsdg import errors
from usdsdg_render.geometry.mesh_source import MeshSource


class UsableFaces(NamedTuple):
    """Faces that can be drawn."""

    faces: np.ndarray  # (K,)
    starts: np.ndarray  # (K,) where they begin in the face-vertex list
    has_bad_points: bool  # whether any point of the mesh is NaN or infinite

    def without(self, holes: np.ndarray) -> UsableFaces:
        """Return all but the faces in `holes`."""
        if not len(holes):
            return self
        drawn = ~np.isin(self.faces, holes)
        return self._replace(faces=self.faces[drawn], starts=self.starts[drawn])


def usable_faces(path: str, source: MeshSource) -> UsableFaces:
    """Return the faces with three or more existing, finite vertices; of all others warn."""
    counts = source.counts.astype(np.int64)
    starts = np.cumsum(np.maximum(counts, 0)) - np.maximum(counts, 0)
    usable = counts >= 3
    _warn_dropped(path, ~usable, ("has", "have"), "fewer than three vertices", "Correct faceVertexCounts.")
    complete = starts + counts <= len(source.indices)
    _warn_dropped(
        path, usable & ~complete, ("lies", "lie"), "beyond the end of faceVertexIndices",
        "Make the counts sum to its length.",
    )  # fmt: skip
    usable &= complete
    total = int(starts[-1] + max(counts[-1], 0))
    if total < len(source.indices):
        errors.warn_once(
            f"{path}: faceVertexCounts sum to {total} but faceVertexIndices has "
            f"{errors.counted(len(source.indices), 'entry', 'entries')}; the rest is not drawn. Make the counts sum to "
            f"its length."
        )
    finite = np.all(np.isfinite(source.points), axis=1)
    out_of_range = (source.indices < 0) | (source.indices >= len(source.points))
    if out_of_range.any():
        bad = _faces_with(out_of_range, starts, counts, usable)
        outside = f"points outside 0..{len(source.points) - 1}"
        _warn_dropped(path, bad, ("names", "name"), outside, "Correct faceVertexIndices.")
        usable &= ~bad
    if not finite.all():
        not_finite = ~finite[np.clip(source.indices, 0, len(finite) - 1)]
        bad = _faces_with(not_finite, starts, counts, usable)
        _warn_dropped(path, bad, ("has", "have"), "a NaN or infinite point", "Correct the points.")
        usable &= ~bad
    return UsableFaces(np.flatnonzero(usable), starts[usable], not finite.all())


def _faces_with(bad: np.ndarray, starts: np.ndarray, counts: np.ndarray, usable: np.ndarray) -> np.ndarray:
    """(F,) bool: the usable faces with a bad face-vertex, given as (N,) bool."""
    total = np.concatenate([[0], np.cumsum(bad)])
    result = np.zeros(len(counts), bool)
    begin = starts[usable]
    result[usable] = total[begin + counts[usable]] > total[begin]
    return result


def _warn_dropped(path: str, dropped: np.ndarray, verbs: tuple[str, str], what: str, remedy: str) -> None:
    """Warn of faces that are left out; verbs: of one face and of several."""
    if count := int(dropped.sum()):
        faces = errors.counted(count, f"face {verbs[0]}", f"faces {verbs[1]}")
        first = int(np.flatnonzero(dropped)[0])
        are = "is" if count == 1 else "are"
        errors.warn_once(f"{path}: {faces} {what} (first: face {first}) and {are} dropped. {remedy}")


def material_slots(path: str, source: MeshSource) -> np.ndarray:
    """(F,) int32 material slot of each face: subsets in order, then one slot for the faces of no subset."""
    count = len(source.subsets)
    slots = np.full(len(source.counts), count, np.int32)
    for slot, faces in enumerate(source.subsets):
        inside = (faces >= 0) & (faces < len(slots))
        if not inside.all():
            errors.warn_once(
                f"{path}: material subset {slot} names faces outside 0..{len(slots) - 1}; they are ignored. "
                f"Correct its indices."
            )
            faces = faces[inside]
        shared = int((slots[faces] != count).sum())
        if shared:
            errors.warn_once(
                f"{path}: material subset {slot} names {errors.counted(shared, 'face')} of the subsets before it; it "
                f"wins. Give each face one material."
            )
        slots[faces] = slot
    return slots
