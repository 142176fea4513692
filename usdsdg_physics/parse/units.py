"""Convert stage units to SI."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from pxr import Usd, UsdGeom, UsdPhysics

from usdsdg_physics.scene.records import Vec3


@dataclass(frozen=True)
class Units:
    """Factors from a stage's units to SI."""

    meters: float
    kilograms: float

    @classmethod
    def of(cls, stage: Usd.Stage) -> Units:
        """Read a stage's metersPerUnit and kilogramsPerUnit."""
        return cls(float(UsdGeom.GetStageMetersPerUnit(stage)), float(UsdPhysics.GetStageKilogramsPerUnit(stage)))

    @property
    def density(self) -> float:
        """Factor to kg/m³."""
        return self.kilograms / self.meters**3

    @property
    def inertia(self) -> float:
        """Factor to kg m²."""
        return self.kilograms * self.meters**2


def scaled_vector(components: Iterable[float], factor: float) -> Vec3:
    """Return three components times a factor, as Python floats."""
    x, y, z = (float(component) * factor for component in components)
    return x, y, z
