"""FBX, as assimp reads it."""

from __future__ import annotations

import importlib.util
import io
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from usdsdg.errors import Unsupported
from usdsdg.image_files.unreadable import UNREADABLE, why_unreadable
from usdsdg.meshes.model import Material, MeshFile, Part, Texture, roughness_of_exponent
from usdsdg.meshes.readers import obj
from usdsdg.meshes.readers.fbx_media import media

# Kinds of pictures, by the numbers of assimp; the first one counts of which there is a picture.
_COLOR, _GLOW, _NORMAL, _METAL, _ROUGHNESS, _OPACITY = (1, 12), (4, 14), (6,), (15,), (16,), (8,)
_UNREAD = {2: "specular", 5: "bump", 7: "shininess", 9: "displacement", 11: "reflection", 13: "bump"}
# The material of what has none.
_STAND_IN = "DefaultMaterial"
_NO_TRANSFORM = (0.0, 0.0, 1.0, 1.0, 0.0)  # of UVs: offset, scale, angle


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
    pictures = _Pictures(file)
    looks = [_Look(pictures, each) for each in scene.materials]
    parts, notes = [], []
    for name, matrix, index in _placed(scene.root_node, np.eye(4)):
        mesh = scene.meshes[index]
        if len(mesh.indices):
            part = _part(mesh, name).moved(matrix)
            parts.append(looks[part.material].shown(part, notes) if part.material is not None else part)
    notes = [*_left_out(file), *pictures.notes, *(note for each in looks for note in each.notes), *notes]
    materials = tuple(each.material for each in looks)
    return MeshFile(tuple(parts), materials, "Y", 1.0, tuple(dict.fromkeys(notes)), tuple(pictures.files))


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

    def __init__(self, pictures: _Pictures, given: Mapping[str, Any]) -> None:
        self.notes: list[str] = []
        self._name = name = str(given.get("NAME") or "Material")
        named = {int(kind): [str(each) for each in paths] for kind, paths in dict(given.get("TEXTURES") or {}).items()}
        images = {
            kinds: pictures.first(path for kind in kinds for path in named.get(kind, ()))
            for kinds in (_COLOR, _GLOW, _NORMAL, _METAL, _ROUGHNESS, _OPACITY)
        }
        if lost := [word for kind, word in _UNREAD.items() if any(named.get(kind, ()))]:
            words = " and ".join(dict.fromkeys(lost))
            self.notes.append(f"the pictures of {words} of the material {name} are left out")
        self._uv_transform = self._transform_of(given, named)
        color = self._color(images[_COLOR], images[_OPACITY])
        glow, normal = images[_GLOW], images[_NORMAL]
        packed = _packed(images[_ROUGHNESS], images[_METAL], f"{name}_metallic_roughness")
        shininess = float(given.get("SHININESS", 0.0))
        roughness = given.get("ROUGHNESS_FACTOR", given.get("$mat.roughnessFactor"))
        roughness = float(roughness) if roughness is not None else roughness_of_exponent(shininess)
        # What a picture is connected to has no value of its own.
        self.material = Material(
            name,
            color=_three(given.get("COLOR_DIFFUSE")) if images[_COLOR] is None else (1.0, 1.0, 1.0),
            color_texture=color and Texture(color, f"{name}_color", is_color=True),
            opacity=float(given.get("OPACITY", 1.0)),
            opacity_from_color=images[_OPACITY] is not None and color is not None and obj.has_alpha(color),
            metallic=1.0 if images[_METAL] is not None else float(given.get("METALLIC_FACTOR", 0.0) or 0.0),
            metallic_texture=packed if images[_METAL] is not None else None,
            roughness=1.0 if images[_ROUGHNESS] is not None else roughness,
            roughness_texture=packed if images[_ROUGHNESS] is not None else None,
            emission=(1.0, 1.0, 1.0) if glow is not None else _three(given.get("COLOR_EMISSIVE"), 0.0),
            emission_texture=glow and Texture(glow, f"{name}_emission", is_color=True),
            normal_texture=normal and Texture(normal, f"{name}_normal"),
        )

    def shown(self, part: Part, notes: list[str]) -> Part:
        """Return a part as the material shows it: with its UVs, and without colors of points that it does not show."""
        if part.uvs is not None and self._uv_transform != _NO_TRANSFORM:
            x, y, width, height, _ = self._uv_transform
            part = replace(part, uvs=part.uvs * (width, height) + (x, y))
        if part.colors is None:
            return part
        if self._name == _STAND_IN:
            return replace(part, material=None)
        notes.append(f"the colors of the points of {part.name} are left out, which {self._name} does not show")
        return replace(part, colors=None)

    def _transform_of(self, given: Mapping[str, Any], named: Mapping[int, list[str]]) -> tuple[float, ...]:
        """Return the transform of the UVs; assimp gives that of the last picture alone."""
        own = tuple(map(float, given.get("UVTRANSFORM_BASE") or _NO_TRANSFORM))
        if len(own) != 5 or own == _NO_TRANSFORM:
            return _NO_TRANSFORM
        if own[4] != 0.0 or sum(map(len, named.values())) > 1:
            self.notes.append(f"the transform of UVs of a picture of the material {self._name} is left out")
            return _NO_TRANSFORM
        return own

    def _color(self, color: Image.Image | None, opacity: Image.Image | None) -> Image.Image | None:
        """Return the picture of the color, with the alpha of that of the opacity.

        Of a picture without alpha, some programs take white for opaque and others for clear.
        """
        if opacity is None or opacity is color:
            return color
        if not obj.has_alpha(opacity):
            self.notes.append(
                f"the picture of the opacity of the material {self._name} has no alpha, so it is left out; give it one"
            )
            return color
        return obj.with_mask(color, opacity)


class _Pictures:
    """The pictures of a file: those inside of it, and those beside it."""

    def __init__(self, file: Path) -> None:
        self.notes: list[str] = []
        self.files: list[str] = []
        self._file = file
        self._images: dict[str, Image.Image | None] = {}

    @cached_property
    def _inside(self) -> dict[str, bytes]:
        return media(self._file.read_bytes())

    def first(self, names: Iterator[str]) -> Image.Image | None:
        """Return the first picture of these names that can be read; maps without a file have no name."""
        for name in filter(None, names):
            if name not in self._images:
                self._images[name] = self._read(name.replace("\\", "/"))
            if self._images[name] is not None:
                return self._images[name]
        return None

    def _read(self, name: str) -> Image.Image | None:
        last = name.rsplit("/", 1)[-1]
        content = self._inside.get(last.lower())
        if content is None:
            path = next((each for each in (self._file.parent / name, self._file.parent / last) if each.is_file()), None)
            if path is None:
                where = f"beside {self._file.name}"
                self.notes.append(f"the picture {name} {where} cannot be read, so its part of the look is left out")
                return None
            self.files.append(str(path.resolve()))
            content = path.read_bytes()
        try:
            with Image.open(io.BytesIO(content)) as image:
                image.load()
                return image.copy()
        except UNREADABLE as error:
            why = why_unreadable(error)
            self.notes.append(f"the picture {name} cannot be read ({why}), so its part of the look is left out")
            return None


def _packed(roughness: Image.Image | None, metal: Image.Image | None, name: str) -> Texture | None:
    """Return one picture as materials have it: roughness in its green, and metalness in its blue channel."""
    if roughness is None and metal is None:
        return None
    size = max(each.size for each in (roughness, metal) if each is not None)
    white = Image.new("L", size, 255)
    green, blue = (white if each is None else each.convert("L").resize(size) for each in (roughness, metal))
    return Texture(Image.merge("RGB", (white, green, blue)), name)


def _three(color: Any, default: float = 1.0) -> tuple[float, float, float]:
    values = [default] * 3 if color is None else [float(each) for each in color][:3]
    return (values[0], values[1], values[2])
