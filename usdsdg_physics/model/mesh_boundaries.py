"""Keep Newton from looking for the open edges of triangle meshes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import warp as wp

_MODULE, _FUNCTION = "newton._src.geometry.sdf_contact", "compute_mesh_boundary_flags"


@contextmanager
def mesh_boundaries_left_out() -> Iterator[None]:
    """Within it, models are finalized as if all triangle meshes were closed.

    Newton needs open edges for contacts between two triangle meshes. Here one of two shapes that collide is always
    convex, and a terrain of a million triangles would load for twice as long. A version of Newton without this function
    looks for them.
    """
    import importlib

    try:
        module = importlib.import_module(_MODULE)
        original = getattr(module, _FUNCTION)
    except (ImportError, AttributeError):
        yield
        return
    setattr(module, _FUNCTION, _none_open)
    try:
        yield
    finally:
        setattr(module, _FUNCTION, original)


def _none_open(mesh: wp.Mesh) -> np.ndarray:
    """Return that no edge and vertex of a mesh's triangles (F,) is open."""
    return np.zeros(mesh.indices.size // 3, np.uint8)
