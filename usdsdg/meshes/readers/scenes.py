"""OBJ, glTF, PLY, STL, COLLADA and OFF, as trimesh reads them."""

from __future__ import annotations

import codecs
import io
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from PIL import Image

from usdsdg.errors import AssetUnreadable, Unsupported
from usdsdg.meshes.model import Material, MeshFile, Part, Texture, roughness_of_exponent
from usdsdg.meshes.readers import gltf
from usdsdg.stage.colors import srgb_to_linear

# By convention: glTF prescribes Y, modeling programs export OBJ with Y, scanners and CAD have Z.
_UP = {".ply": "Z", ".stl": "Z", ".off": "Z"}
_HOW_TO_INSTALL = "pip install 'usdsdg[meshes]'"


def read(file: Path) -> MeshFile:
    """Read a file with trimesh; node transforms are applied, faces with more than three corners are split."""
    import trimesh

    if file.suffix.lower() == ".dae" and not _has_collada():
        raise Unsupported(f"{file}: COLLADA needs the package pycollada; install it with {_HOW_TO_INSTALL}")
    resolver: Any = _Recorder(file)
    is_gltf = file.suffix.lower() in (".glb", ".gltf")
    content, notes = gltf.prepared(file, resolver.get) if is_gltf else (_text_or_bytes(file), [])
    form = "glb" if is_gltf else file.suffix.lower()[1:]
    scene: Any = trimesh.load_scene(io.BytesIO(content), file_type=form, resolver=resolver, process=False)
    materials = _Materials()
    parts = []
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        geometry = scene.geometry[name]
        if isinstance(geometry, trimesh.Trimesh) and len(geometry.faces):
            if file.suffix.lower() == ".stl":
                geometry.merge_vertices()  # a file of separate triangles
            part = _part(str(node), geometry, materials, is_gltf=is_gltf)
            parts.append(part.moved(np.asarray(matrix).T))
    if not parts and file.suffix.lower() == ".stl":
        _check_whole(file, content)
    if not parts and len(scene.geometry):
        raise AssetUnreadable(f"{file} has points or lines but no triangles; give a mesh")
    up, unit = _collada_axes(file) if file.suffix.lower() == ".dae" else (_UP.get(file.suffix.lower(), "Y"), 1.0)
    notes = tuple([*notes, *_missing(file, resolver), *dict.fromkeys(materials.notes)])
    return MeshFile(tuple(parts), tuple(materials.list), up, unit, notes, tuple(sorted(resolver.read)))


class _Materials:
    """Materials in the order of their first use."""

    def __init__(self) -> None:
        self.list: list[Material] = []
        self.notes: list[str] = []
        self._index: dict[int, int] = {}
        self._kept: list[Any] = []  # so that no id is used twice

    def index(self, material: Any) -> int | None:
        if material is None or _is_stand_in(material):
            return None
        if id(material) not in self._index:
            self._index[id(material)] = len(self.list)
            self._kept.append(material)
            self.list.append(_material(material, self.notes))
        return self._index[id(material)]


def _part(name: str, mesh: Any, materials: _Materials, *, is_gltf: bool) -> Part:
    visual = mesh.visual
    uvs = getattr(visual, "uv", None)
    material = getattr(visual, "material", None) if visual.kind == "texture" else None
    colors = np.asarray(visual.vertex_colors)[:, :3] / 255.0 if visual.kind in ("vertex", "face") else None
    # Those that trimesh would compute are not the file's.
    normals = mesh._cache.cache.get("vertex_normals")
    return Part(
        name,
        np.asarray(mesh.vertices, np.float64),
        np.asarray(mesh.faces, np.int64),
        None if normals is None or len(normals) != len(mesh.vertices) else np.asarray(normals, np.float64),
        None if uvs is None or len(uvs) != len(mesh.vertices) else np.asarray(uvs, np.float64)[:, :2],
        colors if colors is None or is_gltf else srgb_to_linear(colors),
        materials.index(material),
        not is_gltf or bool(getattr(material, "doubleSided", False)),
    )


def _material(given: Any, notes: list[str]) -> Material:
    """Convert a material of trimesh: that of glTF, or the simple one of OBJ and COLLADA."""
    name = str(getattr(given, "name", None) or "Material")
    if type(given).__name__ == "PBRMaterial":
        return _metallic_roughness(name, given, notes)
    color = _rgba(getattr(given, "diffuse", None))
    texture = _texture(getattr(given, "image", None), f"{name}_color", notes, is_color=True)
    return Material(
        name,
        # A simple material's color is the texture's where there is one.
        color=(1.0, 1.0, 1.0) if texture is not None else color[:3],
        color_texture=texture,
        opacity=color[3],
        opacity_from_color=_has_alpha(texture),
        roughness=roughness_of_exponent(float(getattr(given, "glossiness", 0.0) or 0.0)),
    )


def _is_stand_in(given: Any) -> bool:
    """Whether trimesh made a material up, for UVs without one: a picture of two by two equal pixels."""
    image, known = getattr(given, "image", None), getattr(given, "kwargs", None)
    return known == {} and image is not None and image.size == (2, 2) and not np.ptp(image, axis=(0, 1)).any()


def _metallic_roughness(name: str, given: Any, notes: list[str]) -> Material:
    color = _rgba(given.baseColorFactor)
    packed = _texture(given.metallicRoughnessTexture, f"{name}_metallic_roughness", notes)
    texture = _texture(given.baseColorTexture, f"{name}_color", notes, is_color=True)
    mode = str(given.alphaMode or "OPAQUE").upper()
    blended = mode in ("BLEND", "MASK")
    cutoff = 0.5 if given.alphaCutoff is None else float(given.alphaCutoff)
    emission = np.asarray(given.emissiveFactor if given.emissiveFactor is not None else (0.0, 0.0, 0.0), float)
    emission_texture = _texture(given.emissiveTexture, f"{name}_emission", notes, is_color=True)
    if emission.max(initial=0.0) > 1.0 and np.issubdtype(np.asarray(given.emissiveFactor).dtype, np.integer):
        emission = emission / 255.0
    return Material(
        name,
        # glTF's factors are linear.
        color=(color[0], color[1], color[2]),
        color_texture=texture,
        opacity=color[3] if blended else 1.0,
        opacity_from_color=blended and _has_alpha(texture),
        opacity_threshold=cutoff if mode == "MASK" else 0.0,
        # The defaults of glTF are 1.
        metallic=1.0 if given.metallicFactor is None else float(given.metallicFactor),
        metallic_texture=packed,
        roughness=1.0 if given.roughnessFactor is None else float(given.roughnessFactor),
        roughness_texture=packed,
        emission=tuple(emission[:3].tolist()),  # pyright: ignore[reportArgumentType]
        emission_texture=emission_texture,
        normal_texture=_texture(given.normalTexture, f"{name}_normal", notes),
        occlusion_texture=_texture(given.occlusionTexture, f"{name}_occlusion", notes),
    )


def _texture(image: Any, name: str, notes: list[str], *, is_color: bool = False) -> Texture | None:
    if not isinstance(image, Image.Image):
        return None
    try:
        image.load()  # trimesh has read its head alone
    except (OSError, ValueError, SyntaxError) as error:
        notes.append(f"the picture {name} cannot be read ({error}), so its part of the look is left out")
        return None
    return Texture(image, name, is_color)


def _has_alpha(texture: Texture | None) -> bool:
    if texture is None or texture.image.mode not in ("RGBA", "LA", "PA"):
        return False
    return bool(np.asarray(texture.image.getchannel("A")).min() < 255)


def _rgba(color: Any) -> tuple[float, float, float, float]:
    """Return a color from 0 to 1; trimesh holds integers up to 255 or floats."""
    if color is None:
        return 1.0, 1.0, 1.0, 1.0
    values = np.asarray(color)
    values = values / 255.0 if np.issubdtype(values.dtype, np.integer) else values.astype(float)
    red, green, blue, alpha = [*values.tolist(), 1.0, 1.0, 1.0, 1.0][:4] if len(values) >= 4 else [*values[:3], 1.0]
    return float(red), float(green), float(blue), float(alpha)


def _text_or_bytes(file: Path) -> bytes:
    """Return the content of a file without a mark of its encoding, which trimesh takes for a part of the first word."""
    return file.read_bytes().removeprefix(codecs.BOM_UTF8)


def _collada_axes(file: Path) -> tuple[str, float]:
    """Return the up axis and meters per unit of a COLLADA file; trimesh applies neither."""
    text = file.read_bytes()[:20000].decode("utf-8", "replace")
    up = re.search(r"<up_axis>\s*([XYZ])_UP\s*</up_axis>", text)
    unit = re.search(r"<unit\b[^>]*\bmeter\s*=\s*[\"']([^\"']+)[\"']", text)
    return (up[1] if up else "Y"), (float(unit[1]) if unit else 1.0)


def _check_whole(file: Path, content: bytes) -> None:
    """Raise an error for a binary STL file that announces more triangles than it has."""
    announced = int.from_bytes(content[80:84], "little")
    there = max(len(content) - 84, 0) // 50
    if there < announced < 1 << 28:
        raise AssetUnreadable(f"{file} is cut off: it has {there} of the {announced} triangles that it announces")


def _has_collada() -> bool:
    import importlib.util

    return importlib.util.find_spec("collada") is not None


class _Recorder:
    """Gives trimesh the files beside a mesh, and notes which were asked for and which are missing."""

    def __init__(self, file: Path) -> None:
        import trimesh

        self._inner = trimesh.resolvers.FilePathResolver(str(file), allow_anywhere=True)
        self._folder = file.parent
        self.read: set[str] = set()
        self.missing: list[str] = []

    def get(self, name: str) -> bytes:
        """Return the bytes of a file."""
        plain = name.strip().replace("\\", "/")
        for candidate in dict.fromkeys((name, plain, unquote(plain), unquote(plain).rsplit("/", 1)[-1])):
            try:
                content = self._inner.get(candidate)
            except (OSError, ValueError):
                continue
            self.read.add(str((self._folder / candidate.removeprefix("./")).resolve()))
            return content
        self.missing.append(unquote(plain))
        raise FileNotFoundError(f"{self._folder} has no {plain}")

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)

    def get_base(self) -> str:
        return str(self._folder)

    def keys(self) -> list[str]:
        return list(self._inner.keys())


def _missing(file: Path, resolver: _Recorder) -> Iterator[str]:
    """Say which materials and pictures a file names that are not there."""
    for name in dict.fromkeys(resolver.missing):
        yield f"{name} is missing beside {file.name}, so its part of the look is left out"
