"""`OmniPBR`: a material of OmniPBR.mdl."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import UsdShade

from usdsdg.compat.isaacsim.core.api.materials.visual_material import VisualMaterial
from usdsdg.compat.wrappers import shaders
from usdsdg.compat.wrappers.prim_paths import prim_of


class OmniPBR(VisualMaterial):
    """OmniPBR: color, texture, roughness, metallic. A new one projects textures and has a roughness of 0.5."""

    _inputs = shaders.OMNI_PBR_INPUTS

    def __init__(
        self,
        prim_path: str,
        name: str = "omni_pbr",
        shader: UsdShade.Shader | None = None,
        texture_path: str | None = None,
        texture_scale: Sequence[float] | np.ndarray | None = None,
        texture_translate: Sequence[float] | np.ndarray | None = None,
        color: Sequence[float] | np.ndarray | None = None,
    ) -> None:
        """Wrap or define the material; the shader is the one that it has.

        Raises:
            AssetNotFound: the texture does not exist.
        """
        is_new = not prim_of(prim_path)
        super().__init__(name, prim_path)
        if is_new:
            self.set_project_uvw(True)
            self.set_reflection_roughness(0.5)
        if color is not None:
            self.set_color(color)
        if texture_path is not None:
            self.set_texture(texture_path)
        if texture_scale is not None:
            self.set_texture_scale(*(float(each) for each in texture_scale))
        if texture_translate is not None:
            self.set_texture_translate(*(float(each) for each in texture_translate))

    @classmethod
    def _define(cls, prim_path: str) -> None:
        shaders.define_mdl(prim_path, "OmniPBR.mdl")

    def set_color(self, color: Sequence[float] | np.ndarray) -> None:
        """Set the diffuse color (3,)."""
        self._set_color("diffuse_color_constant", color)

    def get_color(self) -> np.ndarray | None:
        """Return the diffuse color (3,); None if none is set."""
        return self._get_array("diffuse_color_constant")

    def set_texture(self, path: str) -> None:
        """Set the image of the diffuse color: a file, or a URL under the assets root.

        Raises:
            AssetNotFound: it does not exist.
        """
        self._set("diffuse_texture", path)

    def get_texture(self) -> str | None:
        value = self._get("diffuse_texture")
        return value.path if value else None

    def set_texture_scale(self, x: float, y: float) -> None:
        self._set("texture_scale", (float(x), float(y)))

    def get_texture_scale(self) -> np.ndarray | None:
        return self._get_array("texture_scale")

    def set_texture_translate(self, x: float, y: float) -> None:
        self._set("texture_translate", (float(x), float(y)))

    def get_texture_translate(self) -> np.ndarray | None:
        return self._get_array("texture_translate")

    def set_project_uvw(self, flag: bool) -> None:
        """Set whether textures are projected from the axes, without the mesh's coordinates."""
        self._set("project_uvw", bool(flag))

    def get_project_uvw(self) -> bool | None:
        return self._get("project_uvw")

    def set_reflection_roughness(self, amount: float) -> None:
        self._set("reflection_roughness_constant", float(amount))

    def get_reflection_roughness(self) -> float | None:
        return self._get("reflection_roughness_constant")

    def set_metallic_constant(self, amount: float) -> None:
        self._set("metallic_constant", float(amount))

    def get_metallic_constant(self) -> float | None:
        return self._get("metallic_constant")
