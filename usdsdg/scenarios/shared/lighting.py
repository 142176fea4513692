"""Light that suits objects of any size: a sky whose mean brightness is set, and distant lights."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdLux

from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.shared.pictures import mean_luminance
from usdsdg.stage.poses.xform_ops import author_pose

WHITE = 1500.0  # nits of white in the image
COLOR_TEMPERATURES = (3200.0, 8500.0)  # kelvin


@dataclass(frozen=True)
class Brightness:
    """How bright a white surface is, as fractions of white in the image, drawn log-uniformly from ranges."""

    sky: tuple[float, float]
    lamps: tuple[float, float]
    lamp_count: tuple[int, int]


class Lighting:
    """A dome light for each sky, one of which is visible at a time, and distant lights."""

    def __init__(self, stage: Usd.Stage, skies: Sequence[str], brightness: Brightness) -> None:
        self._skies, self._brightness = list(skies), brightness
        self._domes = [self._dome(stage, index, sky) for index, sky in enumerate(self._skies)]
        self._lamps = [
            UsdLux.DistantLight.Define(stage, f"/World/Lights/Lamp_{index}")
            for index in range(brightness.lamp_count[1])
        ]
        for lamp in self._lamps:
            lamp.CreateEnableColorTemperatureAttr(True)

    def randomize(self, draws: Draws, frame: int) -> None:
        """Draw sky, its turn and its brightness, and number, directions, colors and brightness of the lamps."""
        generator = draws.generator("lights", frame)
        chosen = int(generator.integers(len(self._domes)))
        for index, dome in enumerate(self._domes):
            show(dome.GetPrim(), index == chosen)
        wanted = WHITE * _log_uniform(generator, self._brightness.sky)
        self._domes[chosen].GetIntensityAttr().Set(wanted / mean_luminance(self._skies[chosen]))
        author_pose(self._domes[chosen].GetPrim(), rotate_xyz=(0.0, 0.0, generator.uniform(0.0, 360.0)))
        count = int(generator.integers(self._brightness.lamp_count[0], self._brightness.lamp_count[1] + 1))
        for index, lamp in enumerate(self._lamps):
            show(lamp.GetPrim(), index < count)
            if index < count:
                self._place(lamp, generator, count)

    def _place(self, lamp: UsdLux.DistantLight, generator: np.random.Generator, count: int) -> None:
        """Draw a lamp of the upper hemisphere; several share the brightness of one."""
        lux = math.pi * WHITE * _log_uniform(generator, self._brightness.lamps) / math.sqrt(count)
        lamp.GetIntensityAttr().Set(lux)
        lamp.GetAngleAttr().Set(float(generator.uniform(1.0, 25.0)))
        lamp.GetColorTemperatureAttr().Set(float(generator.uniform(*COLOR_TEMPERATURES)))
        # A distant light shines along its own -Z: not tilted, straight down.
        tilt, turn = generator.uniform(0.0, 75.0), generator.uniform(0.0, 360.0)
        author_pose(lamp.GetPrim(), rotate_xyz=(tilt, 0.0, turn))

    @staticmethod
    def _dome(stage: Usd.Stage, index: int, sky: str) -> UsdLux.DomeLight:
        dome = UsdLux.DomeLight.Define(stage, f"/World/Lights/Sky_{index}")
        dome.CreateTextureFileAttr(Sdf.AssetPath(sky))
        dome.CreateTextureFormatAttr(UsdLux.Tokens.latlong)
        return dome


def show(prim: Usd.Prim, visible: bool) -> None:
    token = UsdGeom.Tokens.inherited if visible else UsdGeom.Tokens.invisible
    attribute = UsdGeom.Imageable(prim).GetVisibilityAttr()
    if attribute.Get() != token:
        attribute.Set(token)


def _log_uniform(generator: np.random.Generator, bounds: tuple[float, float]) -> float:
    low, high = bounds
    return float(low * (high / low) ** generator.random())
