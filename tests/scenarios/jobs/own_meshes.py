"""Three OBJ files as a user may have them: of odd sizes, without normals, one with a texture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

BOX = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
BOX_FACES = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]


def write_three(folder: Path) -> Path:
    """Write block.obj in millimeters, a small textured panel.obj in millimeters, and wedge.obj in meters."""
    folder.mkdir(parents=True, exist_ok=True)
    _write(folder / "block.obj", np.array(BOX) * (60.0, 40.0, 25.0), BOX_FACES)
    wedge = [(0, 0, 0), (0.2, 0, 0), (0.2, 0.1, 0), (0, 0.1, 0), (0, 0, 0.15), (0, 0.1, 0.15)]
    _write(folder / "wedge.obj", np.array(wedge), ["1 4 3 2", "1 2 5", "4 6 3", "2 3 6 5", "1 5 6 4"])
    checks = np.kron(np.indices((4, 4)).sum(axis=0) % 2, np.ones((16, 16), int))[..., None] * (200, 120, 30) + 20
    Image.fromarray(checks.astype(np.uint8)).save(folder / "panel.png")
    (folder / "panel.mtl").write_text("newmtl printed\nKd 1 1 1\nmap_Kd panel.png\n")
    lines = ["mtllib panel.mtl", "usemtl printed"]
    lines += [f"v {x * 12:g} {y * 1.5:g} {z * 9:g}" for x, y, z in BOX]
    lines += ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    lines += ["f " + " ".join(f"{corner}/{k + 1}" for k, corner in enumerate(face.split())) for face in BOX_FACES]
    (folder / "panel.obj").write_text("\n".join(lines) + "\n")
    return folder


def _write(file: Path, points: np.ndarray, faces: list[str]) -> None:
    lines = [f"v {x:g} {y:g} {z:g}" for x, y, z in points.tolist()] + [f"f {face}" for face in faces]
    file.write_text("\n".join(lines) + "\n")
