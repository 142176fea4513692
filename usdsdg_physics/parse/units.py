"""Convert stage units to SI."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from pxr import Usd, UsdPhysics

from usdsdg.errors import warn_once
from usdsdg.stage.poses.transforms import meters_per_unit
from usdsdg_physics.scene.records import Vec3


@dataclass(frozen=True)
class Units:
    """Factors from a stage's units to SI."""

    meters: float
    kilograms: float

    @classmethod
    def of(cls, stage: Usd.Stage) -> Units:
        """Read a stage's metersPerUnit and kilogramsPerUnit; of what is no unit 1 is used, with a warning."""
        kilograms = float(UsdPhysics.GetStageKilogramsPerUnit(stage))
        if not (math.isfinite(kilograms) and kilograms > 0.0):
            warn_once(
                f"{stage.GetRootLayer().identifier}: kilogramsPerUnit {kilograms} is not a mass; 1 is used. "
                "Author a value > 0."
            )
            kilograms = 1.0
        return cls(meters_per_unit(stage), kilograms)

    @property
    def density(self) -> float:
        """Factor to kg/m³."""
        return self.kilograms / self.meters**3

    @property
    def force(self) -> float:
        """Factor to N."""
        return self.kilograms * self.meters

    @property
    def torque(self) -> float:
        """Factor to N m."""
        return self.kilograms * self.meters**2

    @property
    def inertia(self) -> float:
        """Factor to kg m²."""
        return self.kilograms * self.meters**2


def scaled_vector(components: Iterable[float], factor: float) -> Vec3:
    """Return three components times a factor, as Python floats."""
    x, y, z = (float(component) * factor for component in components)
    return x, y, z
