"""UsdGeomMesh to `scene.Prototype`: triangles with faceVarying normals and UVs; invalid faces are dropped."""

from dataclasses import replace

import numpy as np

from usdsdg import errors
from usdsdg.stage.geometry.triangulate import Triangles, triangulate
from usdsdg_render.geometry.color_atlas import atlas_uvs
from usdsdg_render.geometry.face_varying import face_varying_colors, face_varying_normals, face_varying_uvs
from usdsdg_render.geometry.mesh_faces import UsableFaces, material_slots, usable_faces
from usdsdg_render.geometry.mesh_source import MeshSource
from usdsdg_render.geometry.subdivision.surface import refine_mesh
from usdsdg_render.scene.scene import Prototype

# A triangle is degenerate if its height is less than this times its longest edge: in float32 it is a line.
DEGENERATE_RATIO = 1e-7


def build_prototype(path: str, source: MeshSource) -> Prototype | None:
    """Triangulate `source`; None (with a warning) when no valid face with an area is left."""
    slots = material_slots(path, source)
    usable = usable_faces(path, source)
    parents = None  # source face of each refined face
    if source.refinement is not None and (refined := refine_mesh(path, source, usable.faces, usable.starts)):
        source, parents = refined
        counts = source.counts.astype(np.int64)
        usable = UsableFaces(np.arange(len(counts)), np.cumsum(counts) - counts, usable.has_bad_points)
    usable = usable.without(source.holes)
    counts = source.counts[usable.faces].astype(np.int64)
    triangles = triangulate(source.points, counts, source.indices, usable.starts)
    face_vertices = triangles.face_vertices[:, ::-1] if source.left_handed else triangles.face_vertices
    face = usable.faces[triangles.faces]
    points = np.ascontiguousarray(source.points, np.float32)
    vertices = source.indices[face_vertices]
    area_vectors, degenerate = _area_vectors(points, vertices)
    _warn_of_degenerate_faces(path, face if parents is None else parents[face], degenerate)
    solid = ~degenerate
    if not solid.any():
        errors.warn_once(f"{path}: no face of the mesh has an area, so it is not drawn. Check its points and indices.")
        return None
    if degenerate.any():
        face_vertices, face = face_vertices[solid], face[solid]
        vertices, area_vectors = vertices[solid], area_vectors[solid]
    triangles = Triangles(face_vertices, face)
    source_face = face if parents is None else parents[face]
    if usable.has_bad_points:
        points, vertices = _compact(points, vertices)
    triangle_slots = slots[source_face] if source.subsets else np.zeros(len(source_face), np.int32)
    uvs, colors = _paint(path, source, triangles, triangle_slots)
    return Prototype(
        name=path,
        points=points,
        triangles=np.ascontiguousarray(vertices, np.int32),
        normals=face_varying_normals(path, source, triangles, vertices, area_vectors, len(points)),
        uvs=uvs,
        triangle_slots=triangle_slots,
        triangle_faces=source_face.astype(np.int32),
        colors=colors,
        # Texture coordinates of a refined surface are refined with it.
        corners=face_vertices.astype(np.int32) if parents is None else None,
    )


def repainted(path: str, prototype: Prototype, source: MeshSource) -> Prototype:
    """Return the prototype of a mesh that differs from the one of `prototype` only in what is painted on it.

    prototype: one with `corners`.
    """
    assert prototype.corners is not None
    triangles = Triangles(prototype.corners, prototype.triangle_faces)
    uvs, colors = _paint(path, source, triangles, prototype.triangle_slots)
    return replace(prototype, name=path, uvs=uvs, colors=colors)


def _paint(
    path: str, source: MeshSource, triangles: Triangles, slots: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None]:
    """Return texture coordinates and colors of a prototype; where its slots show colors, they refer to their atlas."""
    uvs, colors = face_varying_uvs(path, source, triangles), None
    are_colored = np.isin(slots, source.colored)
    if are_colored.any():
        colors = face_varying_colors(source, triangles)
    if colors is not None:
        uvs[are_colored] = atlas_uvs(len(triangles.faces))[are_colored]
    return uvs, colors


def _area_vectors(points: np.ndarray, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(T, 3) float64 normals, twice the area long, and (T,) bool: which triangles are lines or points."""
    a, b, c = (points[vertices[:, k]].astype(np.float64) for k in range(3))
    ab, ac, bc = b - a, c - a, c - b
    normals = np.empty_like(ab)
    normals[:, 0] = ab[:, 1] * ac[:, 2] - ab[:, 2] * ac[:, 1]
    normals[:, 1] = ab[:, 2] * ac[:, 0] - ab[:, 0] * ac[:, 2]
    normals[:, 2] = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    longest = np.maximum(np.maximum(_dot(ab, ab), _dot(ac, ac)), _dot(bc, bc))
    return normals, ~(_dot(normals, normals) > (DEGENERATE_RATIO * longest) ** 2)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i->...", a, b)


def _warn_of_degenerate_faces(path: str, face: np.ndarray, degenerate: np.ndarray) -> None:
    """Warn of faces without any area. That some triangles of a face are degenerate is ordinary: collinear vertices."""
    if not degenerate.any():
        return
    lost = np.setdiff1d(face[degenerate], face[~degenerate])
    if len(lost):
        errors.warn_once(
            f"{path}: {errors.counted(len(lost), 'face has', 'faces have')} no area (first: face {int(lost[0])}) and "
            f"{'is' if len(lost) == 1 else 'are'} dropped. Merge their points or remove the faces to silence this."
        )


def _compact(points: np.ndarray, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Keep only the points of triangles, so that NaN and infinite ones are gone."""
    used, renumbered = np.unique(vertices, return_inverse=True)
    return points[used], renumbered.reshape(vertices.shape)
