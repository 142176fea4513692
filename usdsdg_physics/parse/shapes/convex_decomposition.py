"""Split meshes into convex parts, once for each content: results are kept on disk.

Pieces of a mesh that are convex as they are, such as the boards of a crate, become parts exactly. CoACD splits the
rest, which takes seconds to minutes.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import astuple, dataclass
from pathlib import Path

import numpy as np

from usdsdg.errors import warn_once
from usdsdg.stage.assets import cache_folder
from usdsdg_physics.parse.shapes.convex_pieces import convex_pieces

# A part of the names of results: another version of the settings below must not find those of this one.
_VERSION = "2"
_FOLDER = "convex_parts"

Part = np.ndarray  # (V, 3) float32 points, whose hull is the part


@dataclass(frozen=True)
class Splitting:
    """How finely a mesh is split."""

    max_parts: int = 32
    max_vertices: int = 64  # of a part
    error: float = 10.0  # percent; PhysX's default


def convex_parts(
    points: np.ndarray,
    triangles: np.ndarray,
    splitting: Splitting,
    *,
    prim_path: str,
    on_split: Callable[[], None] = lambda: None,
) -> list[Part]:
    """Return the points of the convex parts of a mesh; none, with a warning, where it cannot be split.

    Args:
        points: (N, 3) float32.
        triangles: (F, 3) int32.
        on_split: called before the mesh is split; not where its parts are read, from an earlier run.
    """
    digest = hashlib.blake2b(digest_size=16)
    for piece in (_VERSION, str(astuple(splitting)), str(points.shape), points.tobytes(), triangles.tobytes()):
        digest.update(piece if isinstance(piece, bytes) else piece.encode())
    file = cache_folder() / _FOLDER / f"{digest.hexdigest()}.npz"
    parts = _read(file)
    if parts is None:
        on_split()
        parts = _split(points, triangles, splitting, prim_path)
        if parts:
            _write(file, parts)
    return parts


def _split(points: np.ndarray, triangles: np.ndarray, splitting: Splitting, prim_path: str) -> list[Part]:
    most = max(1, splitting.max_parts)
    parts, rest = convex_pieces(points, triangles, most, max(4, splitting.max_vertices))
    if not len(rest):
        return parts
    others = _split_by_coacd(points, rest, splitting, most - len(parts), prim_path)
    return parts + others if others else []


def _split_by_coacd(
    points: np.ndarray, triangles: np.ndarray, splitting: Splitting, max_parts: int, prim_path: str
) -> list[Part]:
    try:
        import coacd
    except ImportError:
        warn_once(
            f"{prim_path}: meshes cannot be split into convex parts, because coacd is not installed, so one convex "
            "hull of each is used and hollows are filled. Run pip install coacd.",
            key="coacd is not installed",
        )
        return []
    coacd.set_log_level("error")
    used, triangles = np.unique(triangles, return_inverse=True)
    points, triangles = points[used], triangles.reshape(-1, 3).astype(np.int32)
    # In a box of size one, so that nothing depends on the units of the mesh.
    low, high = points.min(axis=0).astype(np.float64), points.max(axis=0).astype(np.float64)
    size = float((high - low).max()) or 1.0
    # Fewer trials than CoACD's defaults take a fifth of the time, for one part in ten more.
    found = coacd.run_coacd(
        coacd.Mesh((points - low) / size, triangles),
        threshold=float(np.clip(splitting.error / 200.0, 0.01, 1.0)),
        max_convex_hull=max_parts,
        resolution=1000,
        mcts_nodes=15,
        mcts_iterations=60,
        mcts_max_depth=2,
        decimate=True,
        max_ch_vertex=max(4, splitting.max_vertices),
        seed=0,
    )
    parts = [(np.asarray(vertices) * size + low).astype(np.float32) for vertices, _ in found if len(vertices) > 3]
    if not parts:
        warn_once(f"{prim_path} cannot be split into convex parts; one convex hull is used. Repair its faces.")
    return parts


def _read(file: Path) -> list[Part] | None:
    """Return what an earlier run wrote; None where there is nothing that can be read."""
    try:
        with np.load(file) as stored:
            return np.split(stored["points"], np.cumsum(stored["counts"])[:-1])
    except (OSError, ValueError, KeyError, zipfile.BadZipFile, EOFError, RuntimeError):
        # RuntimeError: damage that looks like a password, or like a later version of zip files.
        return None


def _write(file: Path, parts: list[Part]) -> None:
    """Write a result, whole or not at all; without a writable cache each run splits anew."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=file.parent, suffix=".npz")
        with os.fdopen(handle, "wb") as stream:
            counts = np.array([len(part) for part in parts])
            np.savez(stream, points=np.concatenate(parts), counts=counts)
        os.replace(name, file)
    except OSError as error:
        warn_once(
            f"convex parts of meshes cannot be kept in {file.parent}: {error}. Set XDG_CACHE_HOME to a folder that can "
            "be written to, or each run splits them anew."
        )
