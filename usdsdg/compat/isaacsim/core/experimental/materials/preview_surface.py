"""`PreviewSurfaceMaterial`: materials of UsdPreviewSurface."""

from pxr import Usd

from usdsdg.compat.isaacsim.core.experimental.materials.visual_material import VisualMaterial
from usdsdg.compat.wrappers import shaders


class PreviewSurfaceMaterial(VisualMaterial):
    """UsdPreviewSurface: color, roughness, metallic, opacity."""

    _inputs = shaders.PREVIEW_INPUTS

    @classmethod
    def _define(cls, path: str) -> None:
        shaders.define_preview(path)

    @classmethod
    def _is_kind(cls, prim: Usd.Prim) -> bool:
        return bool(prim) and bool(shaders.preview_shader(prim))
