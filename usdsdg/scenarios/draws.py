"""Random draws keyed by purpose, so that a changed number of objects does not change the other draws."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from pxr import Gf

from usdsdg.graph import sampling

T = TypeVar("T")
Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Placement:
    """Initial pose of an object: position [m], rotation about x, y, z [degrees], one scale for all axes."""

    position: Vector
    rotation: Vector
    scale: float


@dataclass(frozen=True)
class Draws:
    """Draws that depend only on the seed, a purpose string and an index."""

    seed: int
    scenario: str = "object_based"

    def generator(self, purpose: str, index: int = 0) -> np.random.Generator:
        """Return the generator of a purpose and an index."""
        return sampling.generator(self.seed, f"{self.scenario}/{purpose}", index)

    def placement(
        self, purpose: str, index: int, low: Sequence[float], high: Sequence[float], scale: tuple[float, float]
    ) -> Placement:
        """Draw a pose uniformly: in a box, in three angles and in scale."""
        generator = self.generator(purpose, index)
        position = generator.uniform(low, high)
        rotation = generator.uniform(0.0, 360.0, 3)
        return Placement(tuple(position.tolist()), tuple(rotation.tolist()), float(generator.uniform(*scale)))

    def choice(self, purpose: str, index: int, options: Sequence[T]) -> T:
        """Draw one of the options uniformly."""
        return options[int(self.generator(purpose, index).integers(len(options)))]

    def pose_on_sphere(self, purpose: str, index: int, center: Gf.Vec3d, radius: float) -> tuple[Gf.Vec3d, Gf.Quatf]:
        """Draw a camera position uniformly on a sphere, with the smallest rotation that faces the center."""
        generator = self.generator(purpose, index)
        azimuth = generator.uniform(0.0, 2.0 * np.pi)
        height = generator.uniform(-1.0, 1.0)
        radius_at_height = np.sqrt(1.0 - height**2)
        offset = Gf.Vec3d(radius_at_height * np.cos(azimuth), height, radius_at_height * np.sin(azimuth)) * radius
        rotation = Gf.Rotation(Gf.Vec3d(0, 0, -1), -offset.GetNormalized())
        return center + offset, Gf.Quatf(rotation.GetQuat())
