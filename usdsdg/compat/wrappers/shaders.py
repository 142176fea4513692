"""Materials on the stage: OmniPBR, OmniGlass and UsdPreviewSurface, and the inputs of their shaders."""

from __future__ import annotations

from typing import Any

from pxr import Sdf, Usd, UsdShade

from usdsdg.compat import used_stage
from usdsdg.stage import materials
from usdsdg.stage.attributes import asset_path, set_value

_T = Sdf.ValueTypeNames
OMNI_PBR_INPUTS = materials.OMNI_PBR_INPUTS
OMNI_GLASS_INPUTS = {
    **dict.fromkeys(("glass_color", "reflection_color"), _T.Color3f),
    **dict.fromkeys(
        ("glass_color_texture", "roughness_texture", "reflection_color_texture", "normal_map_texture",
         "cutout_opacity_texture"),
        _T.Asset,
    ),
    **dict.fromkeys(
        ("depth", "frosting_roughness", "roughness_texture_influence", "glass_ior", "normal_map_strength",
         "geometry_normal_roughness_strength", "cutout_opacity", "opacity_threshold", "texture_rotate"),
        _T.Float,
    ),
    **dict.fromkeys(
        ("thin_walled", "flip_tangent_u", "flip_tangent_v", "enable_opacity", "project_uvw", "world_or_object"),
        _T.Bool,
    ),
    **dict.fromkeys(("cutout_opacity_mono_source", "uv_space_index"), _T.Int),
    **dict.fromkeys(("texture_translate", "texture_scale"), _T.Float2),
}  # fmt: skip
PREVIEW_INPUTS = {
    **dict.fromkeys(("diffuseColor", "emissiveColor", "specularColor"), _T.Color3f),
    **dict.fromkeys(
        ("metallic", "roughness", "clearcoat", "clearcoatRoughness", "opacity", "opacityThreshold", "ior",
         "displacement"),
        _T.Float,
    ),
    "normal": _T.Normal3f,
    "useSpecularWorkflow": _T.Int,
}  # fmt: skip


def define_mdl(path: str, mdl: str) -> UsdShade.Material:
    """Define a material of an MDL file, such as "OmniPBR.mdl"."""
    return materials.define_mdl(used_stage.current_stage(), path, mdl)


def define_preview(path: str) -> UsdShade.Material:
    """Define a UsdPreviewSurface."""
    stage = used_stage.current_stage()
    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("Shader"))
    shader.CreateIdAttr("UsdPreviewSurface")
    material.CreateSurfaceOutput().ConnectToSource(shader.CreateOutput("surface", _T.Token))
    return material


def mdl_name(prim: Usd.Prim) -> str:
    """Return the name of a material's MDL file in lower case, without its folder; empty for other prims."""
    if not prim or not materials.is_mdl(prim):
        return ""
    return str(mdl_shader(prim).GetSourceAsset("mdl").path).replace("\\", "/").rsplit("/", 1)[-1].lower()


def mdl_shader(prim: Usd.Prim) -> UsdShade.Shader:
    """Return the MDL shader of a material; an invalid one if there is none."""
    return UsdShade.Material(prim).ComputeSurfaceSource("mdl")[0]


def preview_shader(prim: Usd.Prim) -> UsdShade.Shader:
    """Return the UsdPreviewSurface of a material without MDL; an invalid shader if there is none."""
    material = UsdShade.Material(prim)
    shader = material.ComputeSurfaceSource()[0] if material and not materials.is_mdl(prim) else UsdShade.Shader()
    return shader if shader and shader.GetIdAttr().Get() == "UsdPreviewSurface" else UsdShade.Shader()


def surface_shader(prim: Usd.Prim) -> UsdShade.Shader:
    """Return the MDL shader of a material, or its UsdPreviewSurface."""
    return mdl_shader(prim) if materials.is_mdl(prim) else preview_shader(prim)


def set_input(prim: Usd.Prim, name: str, kind: Sdf.ValueTypeName, value: Any) -> None:
    """Set an input of a material's shader.

    Raises:
        AssetNotFound: a texture does not exist.
    """
    if materials.is_mdl(prim):
        materials.set_input(prim, name, value)
        return
    value = asset_path(value) if kind == _T.Asset else value
    set_value(preview_shader(prim).CreateInput(name, kind).GetAttr(), value)
