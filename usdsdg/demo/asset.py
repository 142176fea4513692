"""What an asset is made of before it becomes a USD layer."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from PIL import Image

from usdsdg.demo.shapes.surface import Surface


@dataclass(frozen=True)
class Material:
    """A UsdPreviewSurface. `picture` (sRGB) takes the place of `colour` (linear 0…1)."""

    colour: tuple[float, float, float] = (0.5, 0.5, 0.5)
    picture: Callable[[], Image.Image] | None = None
    roughness: float = 0.5
    metallic: float = 0.0
    clearcoat: float = 0.0
    emissive: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Asset:
    """Bodies by mesh name (one mesh and one collider each) and materials by name.

    standing   True: the origin is the middle of the bottom, as props have it; False: the middle of the box
    mass       kilograms, for the variant with physics
    """

    bodies: Mapping[str, list[Surface]]
    materials: Mapping[str, Material]
    standing: bool = True
    mass: float | None = None
    kind: str = field(default="component")
