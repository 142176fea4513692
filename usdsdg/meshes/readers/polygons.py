"""Polygons of mesh files as triangles: trimesh cuts them to fans, which leave concave ones."""

from __future__ import annotations

import numpy as np

from usdsdg.stage.geometry.triangulate import triangulate


def concave_ones(points: np.ndarray, polygons: list[list[int]]) -> dict[int, np.ndarray]:
    """Return the triangles (T, 3), as positions in the polygon, of each polygon that its fan from the first leaves.

    points: (V, 3). polygons: the points of each, three or more, all of which exist.
    """
    if not polygons:
        return {}
    counts = np.array([len(each) for each in polygons])
    starts = np.cumsum(counts) - counts
    cut = triangulate(points, counts, np.concatenate([np.asarray(each, np.int64) for each in polygons]), starts)
    within = cut.face_vertices - starts[cut.faces][:, None]
    step = np.arange(len(cut.faces)) - (np.cumsum(counts - 2) - (counts - 2))[cut.faces]
    is_fan = (within == np.stack([np.zeros_like(step), step + 1, step + 2], axis=1)).all(axis=1)
    return {face: within[cut.faces == face] for face in np.unique(cut.faces[~is_fan]).tolist()}


def prepared_off(content: bytes) -> bytes:
    """Return an OFF file whose concave polygons are triangles; the file itself where there are none."""
    lines = [line.split(b"#")[0].split() for line in content.splitlines()]
    lines = [line for line in lines if line]
    if not lines or lines[0][:1] != [b"OFF"]:
        return content
    if len(lines[0]) == 1:
        del lines[0]
    else:
        lines[0] = lines[0][1:]
    try:
        vertices, faces = int(lines[0][0]), int(lines[0][1])
        points = np.array([line[:3] for line in lines[1 : vertices + 1]], np.float64)
        rows = [
            [int(each) for each in line[1 : int(line[0]) + 1]] for line in lines[vertices + 1 : vertices + faces + 1]
        ]
    except (ValueError, IndexError):
        return content  # trimesh says what is wrong
    if any(len(row) < 3 or min(row) < 0 or max(row) >= len(points) for row in rows):
        return content
    concave = concave_ones(points, rows)
    if not concave:
        return content
    cut = []
    for number, row in enumerate(rows):
        parts = [[row[k] for k in triangle] for triangle in concave[number]] if number in concave else [row]
        cut += [" ".join(map(str, (len(part), *part))) for part in parts]
    places = "\n".join(" ".join(map(repr, map(float, point))) for point in points)
    return f"OFF\n{vertices} {len(cut)} 0\n{places}\n".encode() + "\n".join(cut).encode() + b"\n"
