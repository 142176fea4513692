"""Boxes, plain or rounded, whose six faces show the six cells of one texture atlas."""

import numpy as np

from usdsdg.demo.shapes.surface import Surface, from_grid, joined, unit

# Right and up vector of each face, seen from outside.
FACE_AXES: dict[str, tuple[tuple[int, int, int], tuple[int, int, int]]] = {
    "+x": ((0, 1, 0), (0, 0, 1)),
    "-x": ((0, -1, 0), (0, 0, 1)),
    "+z": ((1, 0, 0), (0, 1, 0)),
    "+y": ((-1, 0, 0), (0, 0, 1)),
    "-y": ((1, 0, 0), (0, 0, 1)),
    "-z": ((1, 0, 0), (0, -1, 0)),
}
ATLAS_COLUMNS, ATLAS_ROWS = 3, 2


def atlas_cell(face: str) -> tuple[int, int]:
    """Return (column, row from the top) of a face's cell in the atlas of a box."""
    index = list(FACE_AXES).index(face)
    return index % ATLAS_COLUMNS, index // ATLAS_COLUMNS


def box(
    size: tuple[float, float, float], material: str, *, rounding: float = 0.0, steps: int = 3, atlas: bool = True
) -> Surface:
    """A box of `size` [m] centered at the origin, its edges rounded by `rounding` [m] in `steps` facets.

    With `atlas` each face shows its own cell of the material's texture (see `atlas_cell`); without it
    every face shows the whole texture.
    """
    half = np.asarray(size, dtype=float) / 2.0
    rounding = min(rounding, float(half.min()))
    return joined([_face(face, half, rounding, steps, material, atlas) for face in FACE_AXES])


def _face(face: str, half: np.ndarray, rounding: float, steps: int, material: str, atlas: bool) -> Surface:
    right, up = (np.array(axis, dtype=float) for axis in FACE_AXES[face])
    outward = np.cross(right, up)
    columns = _lattice(float(np.abs(right) @ half), rounding, steps)
    rows = _lattice(float(np.abs(up) @ half), rounding, steps)
    on_cube = columns[None, :, None] * right + rows[:, None, None] * up + (np.abs(outward) @ half) * outward
    core = np.clip(on_cube, rounding - half, half - rounding)
    if rounding > 0.0:
        normals = unit(on_cube - core)
        points = core + rounding * normals
    else:
        points, normals = on_cube, np.broadcast_to(outward, on_cube.shape)
    st = np.stack(
        np.broadcast_arrays(
            ((points @ right) / (np.abs(right) @ half) + 1.0) / 2.0, ((points @ up) / (np.abs(up) @ half) + 1.0) / 2.0
        ),
        axis=-1,
    )
    return from_grid(points, normals, _in_cell(st, face) if atlas else st, material)


def _lattice(half: float, rounding: float, steps: int) -> np.ndarray:
    """Coordinates along one edge of a face: dense in the two rounded margins, one span between them."""
    if rounding <= 0.0:
        return np.array([-half, half])
    # This face has half of the edge's quarter circle, hence tan up to 45 degrees.
    margin = half - rounding + rounding * np.tan(np.linspace(0.0, np.pi / 4.0, steps + 1))
    return np.concatenate([-margin[::-1], margin])


def _in_cell(st: np.ndarray, face: str) -> np.ndarray:
    column, row = atlas_cell(face)
    # A small inset keeps bilinear filtering inside the cell.
    inset = 0.004 + 0.992 * st
    return np.stack(
        [(column + inset[..., 0]) / ATLAS_COLUMNS, (ATLAS_ROWS - 1 - row + inset[..., 1]) / ATLAS_ROWS], axis=-1
    )
