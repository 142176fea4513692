"""Subdivision rules in NumPy: Catmull-Clark and Loop, with semi-sharp creases, corners and boundaries.

The rules are those of DeRose, Kass and Truong, "Subdivision Surfaces in Character Animation" (1998), with the blending
of semi-sharp rules that OpenSubdiv documents. Sharpness lives on half-edges (edge k of the face-vertex list runs from
its entry k to the next one of the face), so that refinement hands it on without a search. A mesh that is sharp
everywhere is refined linearly.
"""

from typing import NamedTuple

import numpy as np

# Sharpness from which a crease or corner is infinitely sharp, as in OpenSubdiv.
INFINITE = 10.0


class ControlMesh(NamedTuple):
    """Polygons with values at their vertices: positions, or texture coordinates on their own face-varying topology."""

    values: np.ndarray  # (V, n) float64
    corner_sharpness: np.ndarray  # (V,)
    counts: np.ndarray  # (F,) vertices of each face, >= 3
    indices: np.ndarray  # (N,) vertices of all faces, one face after the other
    crease_sharpness: np.ndarray  # (N,) of the half-edge that starts at each face-vertex


class _Edges(NamedTuple):
    """Edges and half-edges of a mesh."""

    next: np.ndarray  # (N,) next half-edge of the face
    previous: np.ndarray  # (N,)
    edge_of: np.ndarray  # (N,) edge of each half-edge
    vertices: np.ndarray  # (E, 2)
    face_counts: np.ndarray  # (E,) faces at the edge
    sharpness: np.ndarray  # (E,), infinite on boundary and non-manifold edges


def boundary_corners(mesh: ControlMesh) -> np.ndarray:
    """(V,) bool: vertices of a single face, which interpolateBoundary = edgeAndCorner makes infinitely sharp."""
    return np.bincount(mesh.indices, minlength=len(mesh.values)) == 1


def boundary_vertices(mesh: ControlMesh) -> np.ndarray:
    """(V,) bool: vertices of an edge that has a single face."""
    edges = _edges(mesh)
    result = np.zeros(len(mesh.values), bool)
    result[edges.vertices[edges.face_counts == 1]] = True
    return result


def infinitely_sharp(mesh: ControlMesh) -> ControlMesh:
    """Return the mesh with all corners and creases infinitely sharp, so that it is refined linearly."""
    return mesh._replace(
        corner_sharpness=np.full(len(mesh.values), INFINITE), crease_sharpness=np.full(len(mesh.indices), INFINITE)
    )


def refine(mesh: ControlMesh, levels: int, *, loop: bool) -> ControlMesh:
    """Refine a mesh `levels` times by Catmull-Clark, or by Loop's scheme if its faces are triangles.

    Catmull-Clark splits a face of n vertices into n quads, Loop a triangle into four. Child faces are in the order of
    their parents.
    """
    for _ in range(levels):
        mesh = _refine_triangles(mesh) if loop else _refine_quads(mesh)
    return mesh


def child_counts(counts: np.ndarray, levels: int, *, loop: bool) -> np.ndarray:
    """(F,) number of faces that each face is refined to, for levels > 0."""
    return np.full(len(counts), 4**levels) if loop else counts * 4 ** (levels - 1)


def limit_values(mesh: ControlMesh, *, loop: bool) -> np.ndarray:
    """(V, n) values on the limit surface, to which the vertices of a mesh converge under refinement."""
    edges = _edges(mesh)
    valence, ring = _one_ring(mesh, edges)
    value, n = mesh.values, np.maximum(valence, 1)[:, None]
    if loop:
        weight = 1.0 / (3.0 / (8.0 * _loop_weight(np.maximum(valence, 1))) + valence)[:, None]
        smooth = value * (1.0 - n * weight) + ring * weight
    else:
        face_sums = _face_sums(mesh)
        around = _sum_by_index(mesh.indices, np.repeat(face_sums, mesh.counts, axis=0), len(value))
        # For each quad at a vertex, its sum counts the vertex once; all quads together count each neighbor twice.
        opposite = around - n * value - 2.0 * ring
        smooth = (n * n * value + 4.0 * ring + opposite) / (n * (n + 5.0))
    count, neighbors = _neighbor_sums(mesh, edges, edges.sharpness > 0.0)
    crease = (4.0 * value + neighbors) / 6.0
    return _apply_rules(count, mesh.corner_sharpness > 0.0, value, crease, smooth)


def face_varying_normals(mesh: ControlMesh) -> np.ndarray:
    """(N, 3) unit normals at the face-vertices, smooth except across edges that are still sharp."""
    edges = _edges(mesh)
    point = mesh.values[:, :3]
    starts = np.cumsum(mesh.counts) - mesh.counts
    first = np.repeat(point[mesh.indices[starts]], mesh.counts, axis=0)
    here, after = point[mesh.indices] - first, point[mesh.indices[edges.next]] - first
    area = np.repeat(np.add.reduceat(np.cross(here, after), starts), mesh.counts, axis=0)
    group = _smooth_groups(mesh, edges)
    total = _sum_by_index(group, area, int(group.max(initial=-1)) + 1)[group]
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return total / np.where(length > 0.0, length, 1.0)


# Refinement by one level


def _refine_quads(mesh: ControlMesh) -> ControlMesh:
    """Refine by the rules of Catmull and Clark: a point for each vertex, edge and face."""
    edges = _edges(mesh)
    face_points = _face_sums(mesh) / mesh.counts[:, None]
    face_points_at_corners = np.repeat(face_points, mesh.counts, axis=0)
    midpoints = mesh.values[edges.vertices].mean(axis=1)
    smooth = (2.0 * midpoints + _sum_by_index(edges.edge_of, face_points_at_corners, len(midpoints))) / 4.0
    edge_points = _blend(midpoints, smooth, np.clip(edges.sharpness, 0.0, 1.0))
    valence, ring = _one_ring(mesh, edges)
    n = np.maximum(valence, 1)[:, None]
    faces = _sum_by_index(mesh.indices, face_points_at_corners, len(mesh.values))
    vertex_points = _vertex_points(mesh, edges, mesh.values * (n - 2.0) / n + (ring + faces) / (n * n))
    vertices, edge_count = len(mesh.values), len(midpoints)
    face = np.repeat(np.arange(len(mesh.counts)), mesh.counts)
    on_edge, on_face = vertices + edges.edge_of, vertices + edge_count + face
    quads = np.stack([mesh.indices, on_edge, on_face, on_edge[edges.previous]], axis=-1)
    creases = np.zeros(quads.shape)
    sharpness = next_sharpness(mesh.crease_sharpness)
    creases[:, 0], creases[:, 3] = sharpness, sharpness[edges.previous]
    return ControlMesh(
        values=np.concatenate([vertex_points, edge_points, face_points]),
        corner_sharpness=np.concatenate(
            [next_sharpness(mesh.corner_sharpness), np.zeros(edge_count + len(face_points))]
        ),
        counts=np.full(len(quads), 4),
        indices=quads.ravel(),
        crease_sharpness=creases.ravel(),
    )


def _refine_triangles(mesh: ControlMesh) -> ControlMesh:
    """Refine by Loop's rules: a point for each vertex and edge."""
    edges = _edges(mesh)
    midpoints = mesh.values[edges.vertices].mean(axis=1)
    across = _sum_by_index(edges.edge_of, mesh.values[mesh.indices[edges.previous]], len(midpoints))
    edge_points = _blend(midpoints, 0.75 * midpoints + across / 8.0, np.clip(edges.sharpness, 0.0, 1.0))
    valence, ring = _one_ring(mesh, edges)
    weight = _loop_weight(np.maximum(valence, 1))[:, None]
    vertex_points = _vertex_points(mesh, edges, mesh.values * (1.0 - valence[:, None] * weight) + ring * weight)
    on_edge = (len(mesh.values) + edges.edge_of).reshape(-1, 3)
    corner = mesh.indices.reshape(-1, 3)
    sharpness = next_sharpness(mesh.crease_sharpness).reshape(-1, 3)
    triangles, creases = [], []
    for k in range(3):
        triangles.append(np.stack([corner[:, k], on_edge[:, k], on_edge[:, k - 1]], axis=-1))
        creases.append(np.stack([sharpness[:, k], np.zeros(len(corner)), sharpness[:, k - 1]], axis=-1))
    triangles.append(on_edge)
    creases.append(np.zeros((len(corner), 3)))
    return ControlMesh(
        values=np.concatenate([vertex_points, edge_points]),
        corner_sharpness=np.concatenate([next_sharpness(mesh.corner_sharpness), np.zeros(len(midpoints))]),
        counts=np.full(4 * len(corner), 3),
        indices=np.stack(triangles, axis=1).ravel(),
        crease_sharpness=np.stack(creases, axis=1).ravel(),
    )


def next_sharpness(sharpness: np.ndarray) -> np.ndarray:
    """Return the sharpness one level further."""
    return np.where(sharpness >= INFINITE, sharpness, np.maximum(sharpness - 1.0, 0.0))


def _vertex_points(mesh: ControlMesh, edges: _Edges, smooth: np.ndarray) -> np.ndarray:
    """(V, n) vertex points, given those of the smooth rule.

    Semi-sharp vertices blend this level's rule and the next one's by the fractional sharpness that is left.
    """
    value = mesh.values
    now = edges.sharpness > 0.0
    later = next_sharpness(edges.sharpness) > 0.0
    corner_later = next_sharpness(mesh.corner_sharpness) > 0.0
    results = []
    for mask, corner in ((now, mesh.corner_sharpness > 0.0), (later, corner_later)):
        count, neighbors = _neighbor_sums(mesh, edges, mask)
        results.append(_apply_rules(count, corner, value, 0.75 * value + neighbors / 8.0, smooth))
    fading = now & ~later
    count, _ = _neighbor_sums(mesh, edges, fading)
    rest = sum(np.bincount(edges.vertices[fading, k], edges.sharpness[fading], minlength=len(value)) for k in range(2))
    own = (mesh.corner_sharpness > 0.0) & ~corner_later
    weight = (rest + np.where(own, mesh.corner_sharpness, 0.0)) / np.maximum(count + own, 1)
    return np.where(((count + own) > 0)[:, None], _blend(results[0], results[1], weight), results[0])


def _apply_rules(
    count: np.ndarray, corner: np.ndarray, at_corner: np.ndarray, at_crease: np.ndarray, smooth: np.ndarray
) -> np.ndarray:
    """Choose each vertex's rule by the number of its sharp edges: two make a crease, more a corner."""
    result = np.where((count == 2)[:, None], at_crease, smooth)
    return np.where(((count > 2) | corner)[:, None], at_corner, result)


def _blend(sharp: np.ndarray, smooth: np.ndarray, weight: np.ndarray) -> np.ndarray:
    return smooth + (sharp - smooth) * weight[:, None]


def _loop_weight(valence: np.ndarray) -> np.ndarray:
    """Weight of each neighbor in Loop's rule for a smooth vertex."""
    return (0.625 - (0.375 + 0.25 * np.cos(2.0 * np.pi / valence)) ** 2) / valence


# Topology


def _edges(mesh: ControlMesh) -> _Edges:
    half = np.arange(len(mesh.indices))
    ends = np.cumsum(mesh.counts)
    after, previous = half + 1, half - 1
    after[ends - 1] = ends - mesh.counts
    previous[ends - mesh.counts] = ends - 1
    a, b = mesh.indices, mesh.indices[after]
    low, high = np.minimum(a, b).astype(np.int64), np.maximum(a, b).astype(np.int64)
    keys, first, edge_of = np.unique(low * len(mesh.values) + high, return_index=True, return_inverse=True)
    face_counts = np.bincount(edge_of, minlength=len(keys))
    sharpness = np.zeros(len(keys))
    np.maximum.at(sharpness, edge_of, mesh.crease_sharpness)
    sharpness[face_counts != 2] = INFINITE
    return _Edges(after, previous, edge_of, np.stack([low[first], high[first]], axis=-1), face_counts, sharpness)


def _one_ring(mesh: ControlMesh, edges: _Edges) -> tuple[np.ndarray, np.ndarray]:
    """(V,) valences, and (V, n) sums of the neighbors of each vertex."""
    return _neighbor_sums(mesh, edges, np.ones(len(edges.vertices), bool))


def _neighbor_sums(mesh: ControlMesh, edges: _Edges, mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(V,) numbers and (V, n) sums of the neighbors of each vertex across the edges of `mask` (E,)."""
    a, b = edges.vertices[mask].T
    vertex, neighbor = np.concatenate([a, b]), np.concatenate([b, a])
    count = np.bincount(vertex, minlength=len(mesh.values))
    return count, _sum_by_index(vertex, mesh.values[neighbor], len(mesh.values))


def _face_sums(mesh: ControlMesh) -> np.ndarray:
    return np.add.reduceat(mesh.values[mesh.indices], np.cumsum(mesh.counts) - mesh.counts)


def _sum_by_index(index: np.ndarray, rows: np.ndarray, count: int) -> np.ndarray:
    """(count, n) sums of the rows (M, n) that have the same index."""
    return np.stack([np.bincount(index, row, minlength=count) for row in rows.T], axis=-1)


def _smooth_groups(mesh: ControlMesh, edges: _Edges) -> np.ndarray:
    """(N,) group of each face-vertex: one group per vertex and connected fan of faces between sharp edges."""
    count = len(mesh.indices)
    order = np.argsort(edges.edge_of, kind="stable")
    paired = np.flatnonzero((edges.face_counts == 2) & (edges.sharpness <= 0.0))
    begin = (np.cumsum(edges.face_counts) - edges.face_counts)[paired]
    one, other = order[begin], order[begin + 1]
    # The face-vertices at both ends of a half-edge and its twin belong together, also where mixed winding makes the
    # twin run the same way.
    opposed = mesh.indices[one] != mesh.indices[other]
    other_start = np.where(opposed, edges.next[other], other)
    other_end = np.where(opposed, other, edges.next[other])
    links = np.concatenate([[one, other_start], [edges.next[one], other_end]], axis=1)
    label = np.arange(count)
    while True:
        lowest = np.minimum(label[links[0]], label[links[1]])
        new = label.copy()
        np.minimum.at(new, links[0], lowest)
        np.minimum.at(new, links[1], lowest)
        new = new[new]
        if np.array_equal(new, label):
            return np.unique(label, return_inverse=True)[1]
        label = new
