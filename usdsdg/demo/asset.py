"""Geometry and materials of a demo asset, before it is written to USD."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from PIL import Image

from usdsdg.demo.shapes.surface import Surface


@dataclass(frozen=True)
class Material:
    """Inputs of a UsdPreviewSurface. `texture` makes an sRGB image that replaces `color` (linear, 0…1)."""

    color: tuple[float, float, float] = (0.5, 0.5, 0.5)
    texture: Callable[[], Image.Image] | None = None
    roughness: float = 0.5
    metallic: float = 0.0
    clearcoat: float = 0.0
    emissive: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Asset:
    """Bodies by mesh name (one mesh and one collider each) and materials by name.

    origin_at_bottom  True: the origin is the center of the bounding box's bottom; False: the box's center
    mass              kilograms, for the variant with physics
    kind              model kind of the root prim
    """

    bodies: Mapping[str, list[Surface]]
    materials: Mapping[str, Material]
    origin_at_bottom: bool = True
    mass: float | None = None
    kind: str = field(default="component")
