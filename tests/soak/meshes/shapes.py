"""Shapes that the files of the soak hold."""

import numpy as np
import trimesh
from PIL import Image

GREEN = (60, 160, 90, 255)


def cup(scale: float = 1.0) -> trimesh.Trimesh:
    """A closed cup of 9 cm with a wall and a handle, Z up."""
    outside = [(0, 0), (30, 0), (38, 10), (42, 90)]
    inside = [(38, 90), (34, 12), (0, 6)]
    wall = trimesh.creation.revolve(np.array(outside + inside) * 1e-3, sections=48)
    handle = trimesh.creation.torus(0.022, 0.005, major_sections=32, minor_sections=12)
    handle.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (1, 0, 0)))
    handle.apply_translation((0.055, 0, 0.045))
    points = np.concatenate([wall.vertices, handle.vertices]) * scale
    return trimesh.Trimesh(points, np.concatenate([wall.faces, handle.faces + len(wall.vertices)]), process=False)


def colored_cup() -> trimesh.Trimesh:
    """The cup with a color at each point, by its place."""
    mesh = cup()
    low, high = mesh.bounds
    colors = (255 * (mesh.vertices - low) / (high - low)).astype(np.uint8)
    return trimesh.Trimesh(mesh.vertices, mesh.faces, vertex_colors=colors, process=False)


def textured_box(size: float = 0.2) -> trimesh.Trimesh:
    """A box with a checkered picture on each side."""
    box = trimesh.creation.box((size, size, size))
    points = np.asarray(box.vertices)[box.faces].reshape(-1, 3)
    normals = np.repeat(box.face_normals, 3, axis=0)
    axes = np.array([np.flatnonzero(np.abs(normal) < 0.5) for normal in normals])
    uv = np.take_along_axis(points, axes, axis=1) / size + 0.5
    material = trimesh.visual.material.PBRMaterial(name="checker", baseColorTexture=checker(), roughnessFactor=0.6)
    visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return trimesh.Trimesh(points, np.arange(len(points)).reshape(-1, 3), visual=visual, process=False)


def checker(size: int = 64) -> Image.Image:
    """Squares of orange and blue, with one white corner."""
    row, column = np.indices((size, size)) * 8 // size
    pixels = np.where(((row + column) % 2)[..., None], (230, 130, 40), (40, 80, 170)).astype(np.uint8)
    pixels[(row == 0) & (column == 0)] = 255
    return Image.fromarray(pixels)


def obj_text(mesh: trimesh.Trimesh, *, order: tuple[int, ...] = (0, 1, 2)) -> str:
    """The text of an OBJ file of points and faces alone."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in mesh.vertices]
    return "\n".join(lines + ["f " + " ".join(str(face[i] + 1) for i in order) for face in mesh.faces]) + "\n"


def grid(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles (2 count², 3) of a wavy sheet of 1 m."""
    x, y = np.meshgrid(np.linspace(0, 1, count + 1), np.linspace(0, 1, count + 1))
    points = np.stack([x, y, 0.05 * np.sin(12 * x) * np.cos(9 * y)], axis=-1).reshape(-1, 3)
    a = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    b, c = a + 1, a + count + 1
    return points, np.concatenate([np.stack([a, b, c], 1), np.stack([b, c + 1, c], 1)])


def uvs_of(mesh: trimesh.Trimesh) -> np.ndarray:
    """The UVs (P, 2) of a mesh that has some."""
    return np.asarray(getattr(mesh.visual, "uv", ()))


def exported(mesh: trimesh.Trimesh, kind: str, **options: str) -> bytes:
    """The bytes of a file of trimesh."""
    content = mesh.export(file_type=kind, **options)
    return content.encode() if isinstance(content, str) else bytes(content)


def floats(values: object) -> np.ndarray:
    """An array of float32."""
    return np.asarray(values, np.float32)
