"""Subdivision surfaces in NumPy: Catmull-Clark and Loop, with creases, corners and boundaries.

The rules are those of DeRose, Kass and Truong, "Subdivision Surfaces in Character Animation" (1998), with the blending
of semi-sharp rules that OpenSubdiv documents. Sharpness lives on half-edges (edge k of the face-vertex list runs from
its entry k to the next one of the face), so that it follows its edge through the levels without a search. A cage that
is sharp everywhere is refined linearly.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# Sharpness from which an edge or corner stays sharp for ever, as in OpenSubdiv.
INFINITE = 10.0


class Cage(NamedTuple):
    """Polygons with values at their vertices: positions, or texture coordinates on a topology of their own."""

    values: np.ndarray  # (V, n) float64
    corners: np.ndarray  # (V,) sharpness of each vertex
    counts: np.ndarray  # (F,) vertices of each face, >= 3
    indices: np.ndarray  # (N,) face-vertex list
    creases: np.ndarray  # (N,) sharpness of the half-edge that begins here


class _Edges(NamedTuple):
    """The edges of a cage, each once, as half-edges see them."""

    following: np.ndarray  # (N,) the next half-edge of the face
    previous: np.ndarray  # (N,)
    of: np.ndarray  # (N,) edge of each half-edge
    ends: np.ndarray  # (E, 2) vertices
    faces: np.ndarray  # (E,) how many faces share it
    sharpness: np.ndarray  # (E,), infinite where not two faces meet


def boundary_corners(cage: Cage) -> np.ndarray:
    """(V,) vertices of one face alone on the boundary: sharp with interpolateBoundary = edgeAndCorner."""
    return np.bincount(cage.indices, minlength=len(cage.values)) == 1


def boundary_vertices(cage: Cage) -> np.ndarray:
    """(V,) vertices on an edge that has one face only."""
    edges = _edges(cage)
    result = np.zeros(len(cage.values), bool)
    result[edges.ends[edges.faces == 1]] = True
    return result


def refine(cage: Cage, levels: int, *, loop: bool) -> Cage:
    """The cage after so many levels; with Loop's scheme its faces must be triangles.

    A face of n vertices gives n quads first, then each gives four; Loop's scheme gives four triangles. Children come in
    the order of their parents.
    """
    for _ in range(levels):
        cage = _refine_triangles(cage) if loop else _refine_quads(cage)
    return cage


def children(counts: np.ndarray, levels: int, *, loop: bool) -> np.ndarray:
    """(F,) into how many faces each face is refined, for levels > 0."""
    return np.full(len(counts), 4**levels) if loop else counts * 4 ** (levels - 1)


def limit(cage: Cage, *, loop: bool) -> np.ndarray:
    """(V, n) where the vertices of a refined cage end up after infinitely many levels."""
    edges = _edges(cage)
    valence, ring = _ring(cage, edges)
    value, n = cage.values, np.maximum(valence, 1)[:, None]
    if loop:
        share = 1.0 / (3.0 / (8.0 * _loop_share(np.maximum(valence, 1))) + valence)[:, None]
        smooth = value * (1.0 - n * share) + ring * share
    else:
        whole = _face_sums(cage)
        around = _sum_at(cage.indices, np.repeat(whole, cage.counts, axis=0), len(value))
        # The sum over whole quads counts the vertex once and its neighbors twice for each of its faces.
        opposite = around - n * value - 2.0 * ring
        smooth = (n * n * value + 4.0 * ring + opposite) / (n * (n + 5.0))
    sharp, along = _sharp_ring(cage, edges, edges.sharpness > 0.0)
    crease = (4.0 * value + along) / 6.0
    return _by_rule(sharp, cage.corners > 0.0, value, crease, smooth)


def corner_normals(cage: Cage) -> np.ndarray:
    """(N, 3) unit normals at the face-vertices: smooth, but for edges that are still sharp."""
    edges = _edges(cage)
    point = cage.values[:, :3]
    starts = np.cumsum(cage.counts) - cage.counts
    first = np.repeat(point[cage.indices[starts]], cage.counts, axis=0)
    here, after = point[cage.indices] - first, point[cage.indices[edges.following]] - first
    area = np.repeat(np.add.reduceat(np.cross(here, after), starts), cage.counts, axis=0)
    group = _smooth_groups(cage, edges)
    total = _sum_at(group, area, int(group.max(initial=-1)) + 1)[group]
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return total / np.where(length > 0.0, length, 1.0)


# One level


def _refine_quads(cage: Cage) -> Cage:
    """Catmull and Clark's rules."""
    edges = _edges(cage)
    center = _face_sums(cage) / cage.counts[:, None]
    centers = np.repeat(center, cage.counts, axis=0)
    middle = cage.values[edges.ends].mean(axis=1)
    smooth = (2.0 * middle + _sum_at(edges.of, centers, len(middle))) / 4.0
    at_edges = _blend(middle, smooth, np.clip(edges.sharpness, 0.0, 1.0))
    valence, ring = _ring(cage, edges)
    n = np.maximum(valence, 1)[:, None]
    faces = _sum_at(cage.indices, centers, len(cage.values))
    at_vertices = _vertices(cage, edges, cage.values * (n - 2.0) / n + (ring + faces) / (n * n))
    vertices, edge_count = len(cage.values), len(middle)
    face = np.repeat(np.arange(len(cage.counts)), cage.counts)
    quads = np.stack(
        [cage.indices, vertices + edges.of, vertices + edge_count + face, vertices + edges.of[edges.previous]], axis=-1
    )
    creases = np.zeros(quads.shape)
    softer = softened(cage.creases)
    creases[:, 0], creases[:, 3] = softer, softer[edges.previous]
    return Cage(
        values=np.concatenate([at_vertices, at_edges, center]),
        corners=np.concatenate([softened(cage.corners), np.zeros(edge_count + len(center))]),
        counts=np.full(len(quads), 4),
        indices=quads.ravel(),
        creases=creases.ravel(),
    )


def _refine_triangles(cage: Cage) -> Cage:
    """Loop's rules."""
    edges = _edges(cage)
    middle = cage.values[edges.ends].mean(axis=1)
    across = _sum_at(edges.of, cage.values[cage.indices[edges.previous]], len(middle))
    at_edges = _blend(middle, 0.75 * middle + across / 8.0, np.clip(edges.sharpness, 0.0, 1.0))
    valence, ring = _ring(cage, edges)
    share = _loop_share(np.maximum(valence, 1))[:, None]
    at_vertices = _vertices(cage, edges, cage.values * (1.0 - valence[:, None] * share) + ring * share)
    on_edge = (len(cage.values) + edges.of).reshape(-1, 3)
    corner = cage.indices.reshape(-1, 3)
    softer = softened(cage.creases).reshape(-1, 3)
    triangles, creases = [], []
    for k in range(3):
        triangles.append(np.stack([corner[:, k], on_edge[:, k], on_edge[:, k - 1]], axis=-1))
        creases.append(np.stack([softer[:, k], np.zeros(len(corner)), softer[:, k - 1]], axis=-1))
    triangles.append(on_edge)
    creases.append(np.zeros((len(corner), 3)))
    return Cage(
        values=np.concatenate([at_vertices, at_edges]),
        corners=np.concatenate([softened(cage.corners), np.zeros(len(middle))]),
        counts=np.full(4 * len(corner), 3),
        indices=np.stack(triangles, axis=1).ravel(),
        creases=np.stack(creases, axis=1).ravel(),
    )


def softened(sharpness: np.ndarray) -> np.ndarray:
    """Sharpness one level on."""
    return np.where(sharpness >= INFINITE, sharpness, np.maximum(sharpness - 1.0, 0.0))


def _vertices(cage: Cage, edges: _Edges, smooth: np.ndarray) -> np.ndarray:
    """New places of the old vertices. Where the rule is another one a level on, both are blended by what is left."""
    value = cage.values
    now = edges.sharpness > 0.0
    later = softened(edges.sharpness) > 0.0
    corner_later = softened(cage.corners) > 0.0
    results = []
    for mask, corner in ((now, cage.corners > 0.0), (later, corner_later)):
        count, along = _sharp_ring(cage, edges, mask)
        results.append(_by_rule(count, corner, value, 0.75 * value + along / 8.0, smooth))
    fading = now & ~later
    count, _ = _sharp_ring(cage, edges, fading)
    rest = sum(np.bincount(edges.ends[fading, k], edges.sharpness[fading], minlength=len(value)) for k in range(2))
    own = (cage.corners > 0.0) & ~corner_later
    weight = (rest + np.where(own, cage.corners, 0.0)) / np.maximum(count + own, 1)
    return np.where(((count + own) > 0)[:, None], _blend(results[0], results[1], weight), results[0])


def _by_rule(sharp: np.ndarray, corner: np.ndarray, at_corner, at_crease, smooth) -> np.ndarray:
    """Values by the number of sharp edges at each vertex: up to one is smooth, two make a crease, more a corner."""
    result = np.where((sharp == 2)[:, None], at_crease, smooth)
    return np.where(((sharp > 2) | corner)[:, None], at_corner, result)


def _blend(sharp: np.ndarray, smooth: np.ndarray, weight: np.ndarray) -> np.ndarray:
    return smooth + (sharp - smooth) * weight[:, None]


def _loop_share(valence: np.ndarray) -> np.ndarray:
    """Weight of each neighbor in Loop's rule for a smooth vertex."""
    return (0.625 - (0.375 + 0.25 * np.cos(2.0 * np.pi / valence)) ** 2) / valence


# Topology


def _edges(cage: Cage) -> _Edges:
    half = np.arange(len(cage.indices))
    ends = np.cumsum(cage.counts)
    following, previous = half + 1, half - 1
    following[ends - 1] = ends - cage.counts
    previous[ends - cage.counts] = ends - 1
    a, b = cage.indices, cage.indices[following]
    low, high = np.minimum(a, b).astype(np.int64), np.maximum(a, b).astype(np.int64)
    keys, first, of = np.unique(low * len(cage.values) + high, return_index=True, return_inverse=True)
    faces = np.bincount(of, minlength=len(keys))
    sharpness = np.zeros(len(keys))
    np.maximum.at(sharpness, of, cage.creases)
    sharpness[faces != 2] = INFINITE
    return _Edges(following, previous, of, np.stack([low[first], high[first]], axis=-1), faces, sharpness)


def _ring(cage: Cage, edges: _Edges) -> tuple[np.ndarray, np.ndarray]:
    """Number of edges at each vertex (V,), and the sum of the vertices at their other ends (V, n)."""
    return _sharp_ring(cage, edges, np.ones(len(edges.ends), bool))


def _sharp_ring(cage: Cage, edges: _Edges, mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same for some edges only."""
    a, b = edges.ends[mask].T
    near, far = np.concatenate([a, b]), np.concatenate([b, a])
    count = np.bincount(near, minlength=len(cage.values))
    return count, _sum_at(near, cage.values[far], len(cage.values))


def _face_sums(cage: Cage) -> np.ndarray:
    return np.add.reduceat(cage.values[cage.indices], np.cumsum(cage.counts) - cage.counts)


def _sum_at(where: np.ndarray, rows: np.ndarray, count: int) -> np.ndarray:
    """(count, n) sums of the rows (M, n) that go to the same place."""
    return np.stack([np.bincount(where, row, minlength=count) for row in rows.T], axis=-1)


def _smooth_groups(cage: Cage, edges: _Edges) -> np.ndarray:
    """(N,) a number that face-vertices share when they are at one vertex and no sharp edge parts their faces."""
    count = len(cage.indices)
    order = np.argsort(edges.of, kind="stable")
    paired = np.flatnonzero((edges.faces == 2) & (edges.sharpness <= 0.0))
    begin = (np.cumsum(edges.faces) - edges.faces)[paired]
    one, other = order[begin], order[begin + 1]
    # A half-edge meets its twin at both ends; two that run the same way, in a mesh of mixed winding, too.
    opposed = cage.indices[one] != cage.indices[other]
    other_start = np.where(opposed, edges.following[other], other)
    other_end = np.where(opposed, other, edges.following[other])
    links = np.concatenate([[one, other_start], [edges.following[one], other_end]], axis=1)
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
