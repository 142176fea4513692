"""The nine keypoints of a 3D box, by name: L/R is x min/max, D/U y min/max, B/F z min/max, in the prim's own frame."""

import itertools

import numpy as np

CORNERS = tuple("".join(sides) for sides in itertools.product("LR", "DU", "BF"))
CENTER = "Center"

# Pairs of corners that differ in one letter, by the faces that Replicator colors: left "front", right "back".
EDGES: dict[str, tuple[tuple[str, str], ...]] = {
    "front": (("LDB", "LDF"), ("LDF", "LUF"), ("LUF", "LUB"), ("LUB", "LDB")),
    "back": (("RDB", "RDF"), ("RDF", "RUF"), ("RUF", "RUB"), ("RUB", "RDB")),
    "connecting": (("LDB", "RDB"), ("LDF", "RDF"), ("LUB", "RUB"), ("LUF", "RUF")),
}


def keypoints(low: np.ndarray, high: np.ndarray) -> dict[str, np.ndarray]:
    """Return the center and the eight corners of the box from `low` to `high`, (3,) each."""
    bounds = np.stack([low, high]).astype(np.float64)
    points = {
        name: np.array([bounds["LR".index(name[0]), 0], bounds["DU".index(name[1]), 1], bounds["BF".index(name[2]), 2]])
        for name in CORNERS
    }
    return {CENTER: (bounds[0] + bounds[1]) / 2, **points}


def edge_segments(corners: dict[str, np.ndarray]) -> np.ndarray:
    """Return the edges, (12, 2, 3), in the order of `EDGES`."""
    return np.array([[corners[a], corners[b]] for edges in EDGES.values() for a, b in edges])
