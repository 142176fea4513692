"""The job's own random numbers, keyed by purpose, so that a changed count moves nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Gf

from usdsdg.graph import sampling

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Placement:
    """Where something starts: position [m], rotation about x, y, z [degrees], one scale for all axes."""

    position: Vector
    rotation: Vector
    scale: float


@dataclass(frozen=True)
class Draws:
    """Draws that depend on the seed, a purpose in words and a number, and on nothing else."""

    seed: int

    def generator(self, purpose: str, index: int = 0) -> np.random.Generator:
        return sampling.generator(self.seed, f"object_based/{purpose}", index)

    def placement(
        self, purpose: str, index: int, low: Sequence[float], high: Sequence[float], scale: tuple[float, float]
    ) -> Placement:
        """Uniform in a box, in three angles and in scale."""
        generator = self.generator(purpose, index)
        position = generator.uniform(low, high)
        rotation = generator.uniform(0.0, 360.0, 3)
        return Placement(tuple(position.tolist()), tuple(rotation.tolist()), float(generator.uniform(*scale)))

    def choice(self, purpose: str, index: int, options: Sequence):
        """One of the options, each as likely."""
        return options[int(self.generator(purpose, index).integers(len(options)))]

    def pose_on_sphere(self, purpose: str, index: int, centre: Gf.Vec3d, radius: float) -> tuple[Gf.Vec3d, Gf.Quatf]:
        """A camera's position, uniform on a sphere, and the least turn that makes it face the centre."""
        generator = self.generator(purpose, index)
        around = generator.uniform(0.0, 2.0 * np.pi)
        height = generator.uniform(-1.0, 1.0)
        ring = np.sqrt(1.0 - height**2)
        offset = Gf.Vec3d(ring * np.cos(around), height, ring * np.sin(around)) * radius
        turn = Gf.Rotation(Gf.Vec3d(0, 0, -1), -offset.GetNormalized())
        return centre + offset, Gf.Quatf(turn.GetQuat())
