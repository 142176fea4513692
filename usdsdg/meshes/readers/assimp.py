"""FBX, as assimp reads it."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from usdsdg.errors import Unsupported
from usdsdg.image_files.unreadable import UNREADABLE, why_unreadable
from usdsdg.meshes.model import Material, MeshFile, Part, Texture, roughness_of_exponent


def read(file: Path) -> MeshFile:
    """Read an FBX file; node transforms are applied, and the file's units become meters.

    Raises:
        Unsupported: the package assimp-py is not installed.
    """
    if importlib.util.find_spec("assimp_py") is None:
        raise Unsupported(f"{file}: FBX needs the package assimp-py; install it with pip install 'usdsdg[meshes]'")
    import assimp_py

    flags = assimp_py.Process_Triangulate | assimp_py.Process_GlobalScale | assimp_py.Process_SortByPType
    scene = assimp_py.import_file(str(file), flags)
    materials = [_Look(file, each) for each in scene.materials]
    parts = [
        _part(scene.meshes[index], name).moved(matrix)
        for name, matrix, index in _placed(scene.root_node, np.eye(4))
        if len(scene.meshes[index].indices)
    ]
    notes = (*_left_out(file), *(note for each in materials for note in each.notes))
    files = tuple(path for each in materials for path in each.files)
    return MeshFile(tuple(parts), tuple(each.material for each in materials), "Y", 1.0, notes, files)


def _left_out(file: Path) -> Iterator[str]:
    """Name what assimp-py does not give of a file, by the words of the form."""
    content = file.read_bytes()
    if b"SubDeformer" in content:
        # assimp-py has no bones, and its Debone moves only triangles that are bound to a single one.
        yield (
            "the skeleton is left out; the object has the pose in which it was bound, which may not be the pose of the "
            "file. Export it as GLB, of which skinned meshes have the pose of the file"
        )
    if b"AnimationCurve" in content:
        yield "animations are left out"


def _placed(node: Any, above: np.ndarray) -> Iterator[tuple[str, np.ndarray, int]]:
    """Yield the name, row-vector matrix and mesh of each place at which the nodes draw one."""
    matrix = np.asarray(node.transformation, np.float64).reshape(4, 4).T @ above
    for index in node.mesh_indices:
        yield str(node.name), matrix, index
    for child in node.children:
        yield from _placed(child, matrix)


def _part(mesh: Any, name: str) -> Part:
    points = np.asarray(mesh.vertices, np.float64).reshape(-1, 3)
    normals = None if mesh.normals is None else np.asarray(mesh.normals, np.float64).reshape(-1, 3)
    uvs = colors = None
    if mesh.texcoords:
        uvs = np.asarray(mesh.texcoords[0], np.float64).reshape(len(points), -1)[:, :2]
    if mesh.colors:
        colors = np.asarray(mesh.colors[0], np.float64).reshape(len(points), -1)[:, :3]
    triangles = np.asarray(mesh.indices, np.int64).reshape(-1, 3)
    return Part(name or str(mesh.name), points, triangles, normals, uvs, colors, int(mesh.material_index))


class _Look:
    """A material of assimp with the pictures that it names."""

    def __init__(self, file: Path, given: Mapping[str, Any]) -> None:
        self.notes: list[str] = []
        self.files: list[str] = []
        self._file = file
        name = str(given.get("NAME") or "Material")
        pictures = {str(kind): paths for kind, paths in dict(given.get("TEXTURES") or {}).items()}
        color = self._texture(pictures, (1, 12), f"{name}_color", is_color=True)  # diffuse, base color
        diffuse = [float(each) for each in given.get("COLOR_DIFFUSE", (1.0, 1.0, 1.0))][:3]
        shininess = float(given.get("SHININESS", 0.0))
        roughness = given.get("ROUGHNESS_FACTOR", given.get("$mat.roughnessFactor"))
        emission = [float(each) for each in given.get("COLOR_EMISSIVE", (0.0, 0.0, 0.0))][:3]
        self.material = Material(
            name,
            color=(1.0, 1.0, 1.0) if color is not None else (diffuse[0], diffuse[1], diffuse[2]),
            color_texture=color,
            opacity=float(given.get("OPACITY", 1.0)),
            metallic=float(given.get("METALLIC_FACTOR", 0.0) or 0.0),
            roughness=float(roughness) if roughness is not None else roughness_of_exponent(shininess),
            emission=(emission[0], emission[1], emission[2]),
            normal_texture=self._texture(pictures, (6,), f"{name}_normal"),
        )

    def _texture(
        self, pictures: Mapping[str, Any], kinds: tuple[int, ...], name: str, *, is_color: bool = False
    ) -> Texture | None:
        for kind in kinds:
            for given in pictures.get(str(kind), ()):
                plain = str(given).replace("\\", "/")
                found = [self._file.parent / plain, self._file.parent / plain.rsplit("/", 1)[-1]]
                path = next((each for each in found if each.is_file()), None)
                if path is None:
                    where = "inside the file" if plain.startswith("*") else f"beside {self._file.name}"
                    self.notes.append(
                        f"the picture {plain} {where} cannot be read, so its part of the look is left out"
                    )
                    continue
                self.files.append(str(path.resolve()))
                try:
                    with Image.open(path) as image:
                        return Texture(image.copy(), name, is_color)
                except UNREADABLE as error:
                    why = why_unreadable(error)
                    note = f"the picture {plain} cannot be read ({why}), so its part of the look is left out"
                    self.notes.append(note)
        return None
