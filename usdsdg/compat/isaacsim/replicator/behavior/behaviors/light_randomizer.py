"""The behavior that randomizes the color and intensity of lights."""

from __future__ import annotations

from typing import Any, ClassVar

from pxr import Gf, Sdf, Usd, UsdLux

from usdsdg.compat.isaacsim.replicator.behavior.base_behavior import INTERVAL, Variable, variable
from usdsdg.compat.isaacsim.replicator.behavior.prims_behavior import INCLUDE_CHILDREN, SEED, RandomBehavior

_T = Sdf.ValueTypeNames
_ATTRIBUTES = {"inputs:color": _T.Color3f, "inputs:intensity": _T.Float}


class LightRandomizer(RandomBehavior):
    """Draws color and intensity of each light uniformly."""

    BEHAVIOR_NS: ClassVar[str] = "lightRandomizer"
    VARIABLES_TO_EXPOSE: ClassVar[list[Variable]] = [
        INCLUDE_CHILDREN,
        INTERVAL,
        variable("range:minColor", _T.Color3f, Gf.Vec3f(0.1, 0.1, 0.1), "Smallest red, green and blue."),
        variable("range:maxColor", _T.Color3f, Gf.Vec3f(0.9, 0.9, 0.9), "Largest red, green and blue."),
        variable("range:intensity", _T.Float2, Gf.Vec2f(1000.0, 20000.0), "Smallest and largest intensity."),
        SEED,
    ]

    def on_init(self) -> None:
        self._before: dict[Usd.Prim, dict[str, Any]] = {}
        super().on_init()

    def _applies_to(self, prim: Usd.Prim) -> bool:
        return prim.HasAPI(UsdLux.LightAPI)

    def _read_variables(self) -> None:
        self._min_color = self._get_exposed_variable("range:minColor")
        self._max_color = self._get_exposed_variable("range:maxColor")
        self._intensity = self._get_exposed_variable("range:intensity")

    def _remember(self, prim: Usd.Prim) -> None:
        self._before[prim] = {name: prim.CreateAttribute(name, kind).Get() for name, kind in _ATTRIBUTES.items()}

    def _restore(self, prim: Usd.Prim) -> None:
        for name, value in self._before.pop(prim, {}).items():
            if value is not None:
                prim.GetAttribute(name).Set(value)

    def _apply_behavior(self) -> None:
        for prim in self._valid_prims:
            color = [self._rng.uniform(low, high) for low, high in zip(self._min_color, self._max_color)]
            prim.GetAttribute("inputs:color").Set(Gf.Vec3f(*color))
            prim.GetAttribute("inputs:intensity").Set(self._rng.uniform(*self._intensity))
