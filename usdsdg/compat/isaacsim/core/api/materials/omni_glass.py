"""`OmniGlass`: a material of OmniGlass.mdl."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import UsdShade

from usdsdg.compat.isaacsim.core.api.materials.visual_material import VisualMaterial
from usdsdg.compat.wrappers import shaders


class OmniGlass(VisualMaterial):
    """OmniGlass: color, index of refraction, depth of absorption, thin walls."""

    _inputs = shaders.OMNI_GLASS_INPUTS

    def __init__(
        self,
        prim_path: str,
        name: str = "omni_glass",
        shader: UsdShade.Shader | None = None,
        color: Sequence[float] | np.ndarray | None = None,
        ior: float | None = None,
        depth: float | None = None,
        thin_walled: bool | None = None,
    ) -> None:
        """Wrap or define the material; the shader is the one that it has."""
        super().__init__(name, prim_path)
        if color is not None:
            self.set_color(color)
        if ior is not None:
            self.set_ior(ior)
        if depth is not None:
            self.set_depth(depth)
        if thin_walled is not None:
            self.set_thin_walled(thin_walled)

    @classmethod
    def _define(cls, prim_path: str) -> None:
        shaders.define_mdl(prim_path, "OmniGlass.mdl")

    def set_color(self, color: Sequence[float] | np.ndarray) -> None:
        """Set the color of the glass (3,)."""
        self._set_color("glass_color", color)

    def get_color(self) -> np.ndarray | None:
        """Return the color of the glass (3,); None if none is set."""
        return self._get_array("glass_color")

    def set_ior(self, ior: float) -> None:
        """Set the index of refraction."""
        self._set("glass_ior", float(ior))

    def get_ior(self) -> float | None:
        return self._get("glass_ior")

    def set_depth(self, depth: float) -> None:
        """Set the length after which light has the color of the glass."""
        self._set("depth", float(depth))

    def get_depth(self) -> float | None:
        return self._get("depth")

    def set_thin_walled(self, thin_walled: bool) -> None:
        self._set("thin_walled", bool(thin_walled))

    def get_thin_walled(self) -> bool | None:
        return self._get("thin_walled")
