"""The scene as the renderer sees it: plain tables on the host, derived from USD and never edited by hand.

`extract` fills and refreshes a `Scene`; `device` uploads what changed; kernels read the device copy. Units are stage
units, angles radians, colors linear Rec.709, light in nits (cd/m²). Matrices are USD's row-vector 4x4 in float64:
`p_world = [x y z 1] @ local_to_world`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import takewhile
from typing import NamedTuple

import numpy as np

from usdsdg_render.scene import structs

NO_TEXTURE = -1

# A light with uniform emission; a light that illuminates everything and casts full shadows.
NO_EMISSION_PROFILE = NO_LINKS = -1

WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR, WRAP_BLACK = range(4)
TEXELS_SRGB, TEXELS_RAW, TEXELS_SHORT, TEXELS_HALF = range(4)

# NumPy's stubs know no dtype that is a mapping.
MATERIAL = np.dtype(structs.Material.numpy_dtype())  # pyright: ignore[reportCallIssue]

_LIGHT = np.dtype(structs.Light.numpy_dtype())  # pyright: ignore[reportCallIssue]
# The authored fields of structs.Light, and indices where it has addresses.
LIGHT = np.dtype(
    [(name, _LIGHT[name]) for name in takewhile(lambda name: name != "emission_profile", _LIGHT.names or ())]
    + [
        ("power", "f4"),  # relative weight for choosing a light, > 0
        ("emission_profile", "i4"),  # row of Scene.emission_profiles, or NO_EMISSION_PROFILE
        ("links", "i4"),  # row of Scene.light_links, or NO_LINKS
    ],
    align=True,
)


@dataclass(frozen=True, eq=False)
class EmissionProfile:
    """Factors on a light's radiance by direction (IES) and by position (texture); lights share it by identity."""

    # (H, W) float32 factor by direction: row k at k pi / (H - 1) from the light's -z, column k at 2 pi k / W about z,
    # from -x toward -y; W = 1 is axially symmetric.
    ies: np.ndarray | None = None
    # (H, W, 3) float32 linear, of a rect light: the first texel lies at the corner +x +y, the last at -x -y.
    texture: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class LightLinks:
    """Light linking, and the shadow parameters of UsdLuxShadowAPI."""

    lit: np.ndarray | None = None  # (instances,) bool: which ones it illuminates; None = all
    casting: np.ndarray | None = None  # (instances,) bool: which ones cast its shadow; None = all
    shadow_color: tuple[float, float, float] = (0.0, 0.0, 0.0)  # fraction of the light that remains in shadow
    shadow_distance: float = math.inf  # maximum distance to the occluder [stage units]
    shadow_falloff: float = 0.0  # length over which shadows fade out before that distance [stage units]
    shadow_gamma: float = 1.0


class UvTransform(NamedTuple):
    """Texture coordinates of an image: the products of each row with (u, v, 1) of the surface."""

    u_row: tuple[float, float, float] = (1.0, 0.0, 0.0)
    v_row: tuple[float, float, float] = (0.0, 1.0, 0.0)

    @classmethod
    def of(cls, scale: Sequence[float], rotation: float, translation: Sequence[float]) -> UvTransform:
        """Create a UsdTransform2d: scale, then rotation [radians, counter-clockwise], then translation."""
        cos, sin = math.cos(rotation), math.sin(rotation)
        return cls((cos * scale[0], -sin * scale[1], translation[0]), (sin * scale[0], cos * scale[1], translation[1]))

    @classmethod
    def at(cls, place: Sequence[float]) -> UvTransform:
        """Create one that takes all coordinates to the same ones."""
        return cls((0.0, 0.0, place[0]), (0.0, 0.0, place[1]))

    def after(self, first: UvTransform) -> UvTransform:
        """Return the transform that applies `first`, then this one."""
        rows = []
        for u, v, offset in self:
            a, b = first
            rows.append((u * a[0] + v * b[0], u * a[1] + v * b[1], u * a[2] + v * b[2] + offset))
        return UvTransform(*rows)


IDENTITY_UV = UvTransform()


class Texture(NamedTuple):
    """How one image is looked up.

    `texels` are (H, W, 4) uint8, uint16 or float16, row 0 at v = 1 (the top), straight alpha. A look-up returns their
    linear value times `scale` plus `bias`. `tiles` are (slot, texture) with slot = 10 row + column (UDIM - 1001); then
    `texels` are read outside of all tiles.
    """

    path: str
    texels: np.ndarray
    srgb: bool  # only for uint8 texels
    wrap_s: int
    wrap_t: int
    transform: UvTransform = IDENTITY_UV
    scale: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)
    bias: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    tiles: tuple[tuple[int, Texture], ...] = ()


@dataclass(frozen=True)
class Prototype:
    """One mesh, triangulated; shared by every instance that references it.

    Degenerate triangles and non-finite points are gone; winding is counter-clockwise seen from outside
    (`orientation` already applied). Normals, UVs and colors are faceVarying, one for each vertex of each
    triangle, so that seams and hard edges need no split vertices.
    """

    name: str  # path of the first prim with this mesh, for messages
    points: np.ndarray  # (V, 3) float32, object space
    triangles: np.ndarray  # (T, 3) int32 into points
    normals: np.ndarray  # (T, 3, 3) float32, unit
    uvs: np.ndarray  # (T, 3, 2) float32; zeros when the mesh has none
    triangle_slots: np.ndarray  # (T,) int32: which of the instance's material slots
    triangle_faces: np.ndarray  # (T,) int32: face of the source mesh
    colors: np.ndarray | None = None  # (T, 3, 4) float32 linear displayColor, displayOpacity, if they vary
    corners: np.ndarray | None = None  # (T, 3) int32 into the face vertices of the mesh; None: of no mesh, or refined


@dataclass
class Instances:
    """One row per visible gprim (or instance proxy, or point instance), in stage order."""

    paths: tuple[str, ...] = ()
    prototype: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))
    local_to_world: np.ndarray = field(default_factory=lambda: np.zeros((0, 4, 4), np.float64))
    slot_offset: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))  # into Scene.material_slots
    casts_shadow: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))
    # What stands for each instance in all frames, unlike paths whatever other point instancers draw; empty: the paths.
    lasting_paths: tuple[str, ...] = ()

    @property
    def keys(self) -> tuple[str, ...]:
        """Of each instance what is the same in all frames."""
        return self.lasting_paths or self.paths

    def __len__(self) -> int:
        return len(self.paths)


@dataclass
class Dome:
    """All dome lights of the stage as one lat-long environment map in the first dome's frame.

    Row 0 is the pole +z' of the dome's own frame and column u in [0, 1) increases as in UsdLux (see lights/domes.py);
    `dome_from_world` is the 3x3 that takes a world direction (column vector) into the frame the kernel looks up:
    theta = acos(d.z), u = atan2(d.y, d.x) / 2pi.
    """

    texture: np.ndarray  # (H, W, 3) float32; the same object as long as its values are the same
    dome_from_world: np.ndarray  # (3, 3) float32
    visible: bool = True
    diffuse: float = 1.0
    specular: float = 1.0
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)  # radiance of a texel of 1 [nits]

    @property
    def radiance(self) -> np.ndarray:
        """(H, W, 3) float32 [nits]."""
        return self.texture * np.array(self.color, np.float32)


@dataclass
class Scene:
    """The whole scene. `versions[k]` increases when table k changes, so that readers refresh only what changed."""

    prototypes: list[Prototype] = field(default_factory=list)
    instances: Instances = field(default_factory=Instances)
    materials: np.ndarray = field(default_factory=lambda: np.zeros(0, MATERIAL))
    material_slots: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))
    textures: list[Texture] = field(default_factory=list)
    lights: np.ndarray = field(default_factory=lambda: np.zeros(0, LIGHT))
    emission_profiles: list[EmissionProfile] = field(default_factory=list)
    light_links: list[LightLinks] = field(default_factory=list)
    dome: Dome | None = None
    versions: dict[str, int] = field(
        default_factory=lambda: dict.fromkeys(
            ("prototypes", "instances", "transforms", "materials", "textures", "lights", "dome"), 0
        )
    )

    def touch(self, *tables: str) -> None:
        """Mark tables as changed."""
        for table in tables:
            self.versions[table] += 1
