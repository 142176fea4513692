"""OBJ, glTF, PLY, STL, COLLADA and OFF, as trimesh reads them."""

from __future__ import annotations

import codecs
import io
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from PIL import Image

from usdsdg.errors import AssetUnreadable, Unsupported
from usdsdg.image_files.unreadable import UNREADABLE, why_unreadable
from usdsdg.meshes.model import Material, MeshFile, Part, Texture
from usdsdg.meshes.readers import collada, gltf, obj, ply, ply_colors, ply_strips, polygons
from usdsdg.meshes.readers.gltf_looks import Look
from usdsdg.stage.assets.file_checks import check_regular
from usdsdg.stage.colors import srgb_to_linear

# By convention: glTF prescribes Y, modeling programs export OBJ with Y, scanners and CAD have Z.
_UP = {".ply": "Z", ".stl": "Z", ".off": "Z"}
_HOW_TO_INSTALL = "pip install 'usdsdg[meshes]'"


def read(file: Path) -> MeshFile:
    """Read a file with trimesh; node transforms are applied, faces with more than three corners are split."""
    import trimesh

    if file.suffix.lower() == ".dae" and not collada.is_installed():
        raise Unsupported(f"{file}: COLLADA needs the package pycollada; install it with {_HOW_TO_INSTALL}")
    resolver: Any = _Recorder(file)
    is_gltf = file.suffix.lower() in (".glb", ".gltf")
    form = "glb" if is_gltf else file.suffix.lower()[1:]
    looks: list[Look] = []
    notes: list[str] = []
    if is_gltf:
        content, notes, looks = gltf.prepared(file, resolver.get)
    else:
        content = _text_or_bytes(file)
        if form == "obj":
            content, resolver.library, notes, missing = obj.prepared(content, resolver.find)
            resolver.missing += missing
        elif form == "off":
            content = polygons.prepared_off(content)
        elif form == "ply":
            content = ply.prepared(ply_strips.prepared(ply_colors.prepared(content)))
        elif form == "dae":
            content, notes = collada.prepared(content)
    materials = _Materials(looks, resolver)
    parts, count = [], 0
    for piece in ply.by_picture(content) if form == "ply" else [content]:
        scene: Any = trimesh.load_scene(io.BytesIO(piece), file_type=form, resolver=resolver, process=False)
        count += len(scene.geometry)
        for node in scene.graph.nodes_geometry:
            matrix, name = scene.graph[node]
            geometry = scene.geometry[name]
            if isinstance(geometry, trimesh.Trimesh) and len(geometry.faces):
                if form == "stl":
                    geometry.merge_vertices()  # a file of separate triangles
                part = _part(str(node), geometry, materials, is_gltf=is_gltf)
                parts.append(part.moved(np.asarray(matrix).T))
    if not parts and file.suffix.lower() == ".stl":
        _check_whole(file, content)
    if not parts and count:
        raise AssetUnreadable(f"{file} has points or lines but no triangles; give a mesh")
    up, unit = collada.axes(content) if form == "dae" else (_UP.get(file.suffix.lower(), "Y"), 1.0)
    told = dict.fromkeys([*notes, *_missing(file, resolver), *resolver.unread, *materials.notes])
    return MeshFile(tuple(parts), tuple(materials.list), up, unit, tuple(told), tuple(sorted(resolver.read)))


class _Materials:
    """Materials in the order of their first use."""

    def __init__(self, looks: Sequence[Look], resolver: _Recorder) -> None:
        self.list: list[Material] = []
        self.notes: list[str] = []
        self._looks, self._resolver = looks, resolver
        self._index: dict[tuple[int, bool], int] = {}
        self._converted: dict[int, Material] = {}
        self._kept: list[Any] = []  # so that no id is used twice

    def index(self, material: Any, part: str, *, has_colors: bool) -> tuple[int | None, tuple[float, ...] | None]:
        """Return the number of a material, and by what it multiplies the colors of a part's points.

        None for no material, and where the colors of the points do not count.
        """
        if material is None or _is_stand_in(material):
            return None, (1.0, 1.0, 1.0)
        made = self._made(material)
        if has_colors and made.color_texture is not None:
            self.notes.append(f"the colors of the points of {part} are left out, since {made.name} has a picture")
            has_colors = False
        key = id(material), has_colors
        if key not in self._index:
            self._index[key] = len(self.list)
            self.list.append(replace(made, color_from_points=True) if has_colors else made)
        return self._index[key], made.color if has_colors else None

    def _made(self, given: Any) -> Material:
        if id(given) not in self._converted:
            self._kept.append(given)
            self._converted[id(given)] = self._convert(given)
        return self._converted[id(given)]

    def _convert(self, given: Any) -> Material:
        name = str(getattr(given, "name", None) or "Material")
        if type(given).__name__ == "PBRMaterial":
            is_known = name.isdigit() and int(name) < len(self._looks)
            return _of_gltf(self._looks[int(name)] if is_known else Look(name), given, self.notes)
        texture = _texture(getattr(given, "image", None), f"{name}_color", self.notes, is_color=True)
        return obj.material_of(name, given, texture, self._opened, self.notes)

    def _opened(self, name: str) -> Image.Image | None:
        try:
            image = Image.open(io.BytesIO(self._resolver.get(name)))
            image.load()
        except FileNotFoundError:
            return None
        except UNREADABLE as error:
            self.notes.append(_unread(name, error))
            return None
        return image


def _part(name: str, mesh: Any, materials: _Materials, *, is_gltf: bool) -> Part:
    visual = mesh.visual
    uvs = getattr(visual, "uv", None)
    material = getattr(visual, "material", None) if visual.kind == "texture" else None
    # Those that trimesh would compute are not the file's.
    normals = mesh._cache.cache.get("vertex_normals")
    made = Part(
        name,
        np.asarray(mesh.vertices, np.float64),
        np.asarray(mesh.faces, np.int64),
        None if normals is None or len(normals) != len(mesh.vertices) else np.asarray(normals, np.float64),
        None if uvs is None or len(uvs) != len(mesh.vertices) else _pairs(np.asarray(uvs, np.float64)),
        _colors(mesh, is_gltf=is_gltf),
        is_double_sided=not is_gltf or bool(getattr(material, "doubleSided", False)),
    )
    number, factor = materials.index(material, name, has_colors=made.colors is not None)
    if made.colors is None or factor is None:
        return replace(made, material=number, colors=None)
    return replace(made, material=number, colors=made.colors * np.array(factor))


def _pairs(uvs: np.ndarray) -> np.ndarray:
    """Return UVs (N, 2) of one, two or three numbers; a second that is missing is 0."""
    return uvs[:, :2] if uvs.shape[1] > 1 else np.hstack([uvs, np.zeros_like(uvs)])


def _colors(mesh: Any, *, is_gltf: bool) -> np.ndarray | None:
    """Return the linear colors of points (P, 3), or of the corners of triangles (T * 3, 3); None for no colors."""
    visual = mesh.visual
    if visual.kind == "face":
        return srgb_to_linear(np.repeat(np.asarray(visual.face_colors)[:, :3] / 255.0, 3, axis=0))
    colors = visual.vertex_colors if visual.kind == "vertex" else None
    if visual.kind == "texture":
        given = getattr(visual, "vertex_attributes", None) or {}
        colors = given.get("color", mesh.vertex_attributes.get("color"))  # of glTF, and of other forms
    if colors is None or np.ndim(colors) != 2 or len(colors) != len(mesh.vertices):
        return None
    colors = np.asarray(colors)
    most = float(np.iinfo(colors.dtype).max) if colors.dtype.kind in "iu" else 1.0
    values = colors[:, :3].astype(np.float64) / most
    return values if is_gltf else srgb_to_linear(values)


def _is_stand_in(given: Any) -> bool:
    """Whether trimesh made a material up, for UVs without one: a picture of two by two equal pixels."""
    image, known = getattr(given, "image", None), getattr(given, "kwargs", None)
    return known == {} and image is not None and image.size == (2, 2) and not np.ptp(image, axis=(0, 1)).any()


def _of_gltf(look: Look, given: Any, notes: list[str]) -> Material:
    name = look.name

    def texture(role: str, image: Any, *, is_color: bool = False) -> Texture | None:
        suffix = "metallic_roughness" if role == "packed" else role
        found = _texture(image, f"{name}_{suffix}", notes, is_color=is_color)
        return found and replace(found, wraps=look.wraps.get(role, found.wraps))

    color = look.color
    packed, picture = (
        texture("packed", given.metallicRoughnessTexture),
        texture("color", given.baseColorTexture, is_color=True),
    )
    mode = str(given.alphaMode or "OPAQUE").upper()
    blended = mode in ("BLEND", "MASK")
    cutoff = 0.5 if given.alphaCutoff is None else float(given.alphaCutoff)
    emission = np.asarray(look.emission if any(look.emission) else (0.0, 0.0, 0.0), float)
    # The defaults of glTF are 1.
    metallic = 1.0 if given.metallicFactor is None else float(given.metallicFactor)
    roughness = 1.0 if given.roughnessFactor is None else float(given.roughnessFactor)
    specular = glossy = None
    if look.is_unlit:
        metallic, roughness, packed = 0.0, 1.0, None
    elif look.specular is not None:
        specular, glossy, packed = (look.specular[0], look.specular[1], look.specular[2]), packed, None
        metallic, roughness = 0.0, 1.0 - look.glossiness
    return Material(
        name,
        # glTF's factors are linear.
        color=(color[0], color[1], color[2]),
        color_texture=picture,
        # UsdPreviewSurface has no glass; a clear pane is nearest to it.
        opacity=(color[3] if blended else 1.0) * (1.0 - look.transmission),
        opacity_from_color=blended and picture is not None and obj.has_alpha(picture.image),
        opacity_threshold=cutoff if mode == "MASK" else 0.0,
        metallic=metallic,
        metallic_texture=packed,
        roughness=roughness,
        roughness_texture=packed,
        specular=specular,
        glossy_texture=glossy,
        emission=tuple(emission[:3].tolist()),  # pyright: ignore[reportArgumentType]
        emission_texture=texture("emission", given.emissiveTexture, is_color=True),
        normal_texture=texture("normal", given.normalTexture),
        normal_scale=look.normal_scale,
        occlusion_texture=texture("occlusion", given.occlusionTexture),
        ior=look.ior,
        clearcoat=look.clearcoat,
        clearcoat_roughness=look.clearcoat_roughness,
    )


def _texture(image: Any, name: str, notes: list[str], *, is_color: bool = False) -> Texture | None:
    if not isinstance(image, Image.Image):
        return None
    try:
        image.load()  # trimesh has read its head alone
    except UNREADABLE as error:
        notes.append(_unread(name, error))
        return None
    return Texture(image, name, is_color)


def _text_or_bytes(file: Path) -> bytes:
    """Return the content of a file without a mark of its encoding, which trimesh takes for a part of the first word."""
    return file.read_bytes().removeprefix(codecs.BOM_UTF8)


def _unread(name: str, error: Exception) -> str:
    return f"the picture {name} cannot be read ({why_unreadable(error)}), so its part of the look is left out"


def _check_whole(file: Path, content: bytes) -> None:
    """Raise an error for a binary STL file that announces more triangles than it has."""
    announced = int.from_bytes(content[80:84], "little")
    there = max(len(content) - 84, 0) // 50
    if there < announced < 1 << 28:
        raise AssetUnreadable(f"{file} is cut off: it has {there} of the {announced} triangles that it announces")


class _Recorder:
    """Gives trimesh the files beside a mesh, and notes which were asked for and which are missing."""

    def __init__(self, file: Path) -> None:
        import trimesh

        self._inner = trimesh.resolvers.FilePathResolver(str(file), allow_anywhere=True)
        self._folder = file.parent
        self._is_gltf = file.suffix.lower() in (".glb", ".gltf")  # of which other files than pictures are asked for
        self.read: set[str] = set()
        self.missing: list[str] = []
        self.unread: list[str] = []  # notes of pictures, which trimesh leaves out without a word
        self.library: bytes | None = None  # the materials of an OBJ file

    def get(self, name: str) -> bytes:
        """Return the bytes of a file."""
        content = self.find(name)
        if content is None:
            self.missing.append(unquote(name.strip().replace("\\", "/")))
            raise FileNotFoundError(f"{self._folder} has no {self.missing[-1]}")
        if content is not self.library and not self._is_gltf:
            try:
                Image.open(io.BytesIO(content)).close()
            except UNREADABLE as error:
                self.unread.append(_unread(name, error))
        return content

    def find(self, name: str) -> bytes | None:
        """Return the bytes of a file; None where there is none; raises AssetUnreadable for a device or a pipe."""
        if self.library is not None and name == obj.LIBRARY:
            return self.library
        plain = name.strip().replace("\\", "/")
        names = (name, plain, unquote(plain), unquote(plain).rsplit("/", 1)[-1])
        for candidate in dict.fromkeys((*names, *filter(None, map(self._in_any_case, names[2:])))):
            check_regular(str(self._folder / candidate))
            try:
                content = self._inner.get(candidate)
            except (OSError, ValueError):
                continue
            self.read.add(str((self._folder / candidate.removeprefix("./")).resolve()))
            return content
        return None

    def _in_any_case(self, name: str) -> str | None:
        """Return the name of the only file that differs from this one in the case of its letters, as on Windows."""
        folder, _, last = name.rpartition("/")
        try:
            found = [each.name for each in (self._folder / folder).iterdir() if each.name.lower() == last.lower()]
        except OSError:
            return None
        return f"{folder}/{found[0]}" if folder and len(found) == 1 else found[0] if len(found) == 1 else None

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
