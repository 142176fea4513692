"""A mesh file in memory, whatever its form: parts with materials, in the file's own axes and units."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from PIL import Image


@dataclass(frozen=True)
class Texture:
    """A picture that a material shows."""

    image: Image.Image
    name: str  # of its file, without folder and extension
    is_color: bool = False  # sRGB; otherwise numbers
    wraps: tuple[str, str] = ("repeat", "repeat")  # along u and v, as USD calls them


@dataclass(frozen=True)
class Material:
    """A metallic-roughness material. Colors are linear, each factor multiplies its texture."""

    name: str = "Material"
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    color_texture: Texture | None = None
    color_from_points: bool = False  # that of the points counts, of which `color` is then a factor already
    opacity: float = 1.0
    opacity_from_color: bool = False  # the alpha of the color texture counts
    opacity_texture: Texture | None = None  # the red channel, where the alpha of the color does not count
    opacity_threshold: float = 0.0  # above 0: what is less opaque is a hole
    metallic: float = 0.0
    metallic_texture: Texture | None = None  # the blue channel
    roughness: float = 0.5
    roughness_texture: Texture | None = None  # the green channel
    specular: tuple[float, float, float] | None = None  # reflected head-on, of what has no metallic
    glossy_texture: Texture | None = None  # specular color, and as alpha what is multiplied by 1 - roughness
    emission: tuple[float, float, float] = (0.0, 0.0, 0.0)
    emission_texture: Texture | None = None
    normal_texture: Texture | None = None
    normal_scale: float = 1.0
    occlusion_texture: Texture | None = None  # the red channel
    ior: float = 1.5
    clearcoat: float = 0.0
    clearcoat_roughness: float = 0.01
    is_presence: bool = False  # whether opacity is the part of the surface that exists, instead of that of a pane


def roughness_of_exponent(exponent: float) -> float:
    """Return the roughness whose highlights are as wide as those of a Blinn-Phong exponent; one half for none."""
    return float(np.clip((2.0 / (exponent + 2.0)) ** 0.25, 0.05, 1.0)) if exponent > 0.0 else 0.5


@dataclass(frozen=True)
class Part:
    """Triangles with one material."""

    name: str
    points: np.ndarray  # (P, 3) float64
    triangles: np.ndarray  # (T, 3) int64, counterclockwise from outside
    normals: np.ndarray | None = None  # (P, 3) or (T * 3, 3); None: the file has none
    uvs: np.ndarray | None = None  # (P, 2) or (T * 3, 2), origin at the lower left
    colors: np.ndarray | None = None  # (P, 3) or (T * 3, 3), linear
    material: int | None = None  # index into the materials
    is_double_sided: bool = True

    @property
    def used_points(self) -> np.ndarray:
        """Whether a triangle uses each point (P,)."""
        used = np.zeros(len(self.points), bool)
        used[self.triangles.ravel()] = True
        return used

    def moved(self, matrix: np.ndarray) -> Part:
        """Return the part with its points and normals transformed by a row-vector matrix (4, 4)."""
        linear = matrix[:3, :3]
        with np.errstate(invalid="ignore", over="ignore"):  # repairs remove what is not finite
            points, normals, triangles = self.points @ linear + matrix[3, :3], self.normals, self.triangles
        determinant = np.linalg.det(linear)
        if normals is not None and determinant != 0.0:
            normals = normals @ np.linalg.inv(linear).T
            normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        if determinant < 0.0:
            return replace(self, points=points, normals=normals).flipped()
        return replace(self, points=points, normals=normals, triangles=triangles)

    def flipped(self) -> Part:
        """Return the part with its triangles the other way round; values per corner stay with their corners."""
        order = np.arange(len(self.triangles) * 3).reshape(-1, 3)[:, ::-1].ravel()
        per_corner = len(order)

        def follow(values: np.ndarray | None) -> np.ndarray | None:
            is_per_corner = values is not None and len(values) == per_corner != len(self.points)
            return values[order] if values is not None and is_per_corner else values

        return replace(
            self,
            triangles=self.triangles[:, ::-1],
            normals=follow(self.normals),
            uvs=follow(self.uvs),
            colors=follow(self.colors),
        )


@dataclass(frozen=True)
class MeshFile:
    """What a mesh file holds."""

    parts: tuple[Part, ...]
    materials: tuple[Material, ...] = ()
    up_axis: str = "Y"
    meters_per_unit: float = 1.0
    notes: tuple[str, ...] = ()  # what was missing or left out, for the report
    files: tuple[str, ...] = ()  # other files that it was made of

    @property
    def bounds(self) -> np.ndarray:
        """The (2, 3) smallest and largest coordinates of all points that triangles use."""
        used = np.concatenate([part.points[part.used_points] for part in self.parts])
        return np.stack([used.min(axis=0), used.max(axis=0)])

    @property
    def triangle_count(self) -> int:
        """The number of triangles of all parts."""
        return sum(len(part.triangles) for part in self.parts)

    def moved(self, matrix: np.ndarray) -> MeshFile:
        """Return it with all parts transformed by a row-vector matrix (4, 4)."""
        return replace(self, parts=tuple(part.moved(matrix) for part in self.parts))


@dataclass
class Report:
    """What a conversion did, for the person who asked for it."""

    size: tuple[float, float, float] = (0.0, 0.0, 0.0)  # extent along x, y, z [m]
    triangles: int = 0
    parts: int = 0
    materials: int = 0
    repairs: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
