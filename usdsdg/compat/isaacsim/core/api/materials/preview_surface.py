"""`PreviewSurface`: a UsdPreviewSurface."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import UsdShade

from usdsdg.compat.isaacsim.core.api.materials.visual_material import VisualMaterial
from usdsdg.compat.wrappers import shaders


class PreviewSurface(VisualMaterial):
    """UsdPreviewSurface: color, roughness, metallic."""

    _inputs = shaders.PREVIEW_INPUTS

    def __init__(
        self,
        prim_path: str,
        name: str = "preview_surface",
        shader: UsdShade.Shader | None = None,
        color: Sequence[float] | np.ndarray | None = None,
        roughness: float | None = None,
        metallic: float | None = None,
    ) -> None:
        """Wrap or define the material; the shader is the one that it has."""
        super().__init__(name, prim_path)
        if color is not None:
            self.set_color(color)
        if roughness is not None:
            self.set_roughness(roughness)
        if metallic is not None:
            self.set_metallic(metallic)

    @classmethod
    def _define(cls, prim_path: str) -> None:
        shaders.define_preview(prim_path)

    def set_color(self, color: Sequence[float] | np.ndarray) -> None:
        """Set the diffuse color (3,)."""
        self._set_color("diffuseColor", color)

    def get_color(self) -> np.ndarray | None:
        """Return the diffuse color (3,); None if none is set."""
        return self._get_array("diffuseColor")

    def set_roughness(self, roughness: float) -> None:
        self._set("roughness", roughness)

    def get_roughness(self) -> float | None:
        return self._get("roughness")

    def set_metallic(self, metallic: float) -> None:
        self._set("metallic", metallic)

    def get_metallic(self) -> float | None:
        return self._get("metallic")
