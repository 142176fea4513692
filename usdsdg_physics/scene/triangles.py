"""What triangles of a mesh have in common."""

import numpy as np


def is_closed(triangles: np.ndarray) -> bool:
    """Return whether two of the triangles (F, 3) meet at each edge, by the points that they share."""
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return bool((np.unique(edges, axis=0, return_counts=True)[1] == 2).all())
