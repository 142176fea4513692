"""MDL materials as Omniverse authors them, with a UsdPreviewSurface for viewers without MDL."""

import difflib
from numbers import Integral, Real
from typing import Any

from pxr import Sdf, Usd, UsdShade

from usdsdg.errors import BadPrim
from usdsdg.stage.attributes import asset_path, set_value
from usdsdg.stage.paths import free_paths
from usdsdg.stage.prims.copies import copy_prim
from usdsdg.stage.scopes import LOOKS, define_scope

_T = Sdf.ValueTypeNames
_KINDS = {
    _T.Color3f: "diffuse_color_constant diffuse_tint emissive_color",
    _T.Float2: "texture_translate texture_scale detail_texture_translate detail_texture_scale",
    _T.Float: "albedo_desaturation albedo_add albedo_brightness reflection_roughness_constant "
    "reflection_roughness_texture_influence metallic_constant metallic_texture_influence specular_level ao_to_diffuse "
    "emissive_intensity opacity_constant opacity_threshold geometry_normal_roughness_strength bump_factor "
    "detail_bump_factor texture_rotate detail_texture_rotate",
    _T.Bool: "enable_ORM_texture enable_emission enable_opacity enable_opacity_texture flip_tangent_u flip_tangent_v "
    "project_uvw world_or_object excludeFromWhiteMode",
    _T.Int: "opacity_mode uv_space_index",
    _T.Asset: "diffuse_texture reflectionroughness_texture metallic_texture ORM_texture ao_texture "
    "emissive_color_texture emissive_mask_texture opacity_texture normalmap_texture detail_normalmap_texture",
}
# The inputs of OmniPBR and their types, as its documentation lists them.
OMNI_PBR_INPUTS = {name: kind for kind, names in _KINDS.items() for name in names.split()}

# The inputs of UsdPreviewSurface with the same meaning.
_PREVIEW = {
    "diffuse_color_constant": ("diffuseColor", _T.Color3f),
    "reflection_roughness_constant": ("roughness", _T.Float),
    "metallic_constant": ("metallic", _T.Float),
    "emissive_color": ("emissiveColor", _T.Color3f),
}


def define_mdl(stage: Usd.Stage, path: str, mdl: str) -> UsdShade.Material:
    """Define a material at `path` whose surface is the material of an MDL file ("OmniPBR.mdl") with the file's name."""
    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("Shader"))
    shader.SetSourceAsset(Sdf.AssetPath(mdl), "mdl")
    shader.SetSourceAssetSubIdentifier(_identifier(mdl), "mdl")
    out = shader.CreateOutput("out", _T.Token)
    for make in (material.CreateSurfaceOutput, material.CreateVolumeOutput, material.CreateDisplacementOutput):
        make("mdl").ConnectToSource(out)
    if _identifier(mdl) == "OmniPBR":
        preview = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("PreviewSurface"))
        preview.CreateIdAttr("UsdPreviewSurface")
        preview.CreateInput("diffuseColor", _T.Color3f).Set((0.2, 0.2, 0.2))
        material.CreateSurfaceOutput().ConnectToSource(preview.CreateOutput("surface", _T.Token))
    return material


def new_omni_pbr(stage: Usd.Stage, count: int) -> list[str]:
    """Define OmniPBR materials below `/Replicator/Looks` and return their paths.

    The first is copied, in one change: one by one, each would take as long as there are materials.
    """
    define_scope(stage, LOOKS)
    made = free_paths(stage, f"{LOOKS}/OmniPBR", count)
    if made:
        define_mdl(stage, made[0], "OmniPBR.mdl")
        target = stage.GetEditTarget()
        copy_prim(stage, target.GetLayer(), target.MapToSpecPath(Sdf.Path(made[0])), made[1:])
    return made


def input_owner(material: Usd.Prim, name: str) -> Usd.Prim:
    """Return the prim that has an input of a material: its surface shader, MDL first, or where that takes the value
    from the material or has no such input, a material that has one; the material itself if it has no shader."""
    name = f"inputs:{name.removeprefix('inputs:')}"
    source = UsdShade.Material(material).ComputeSurfaceSource("mdl")
    shader = source[0].GetPrim() if source and source[0] else None
    if shader is None:
        return material
    own = material.HasAttribute(name)
    connected = own and shader.HasAttribute(name) and shader.GetAttribute(name).HasAuthoredConnections()
    return material if connected or (own and not shader.HasAttribute(name)) else shader


def input_type(shader: Usd.Prim, name: str) -> Sdf.ValueTypeName | None:
    """Return the type of an input of an OmniPBR shader; None for other shaders, and for what OmniPBR does not have."""
    mdl = _mdl_shader(shader)
    is_omni_pbr = mdl is not None and str(mdl.GetSourceAssetSubIdentifier("mdl")) == "OmniPBR"
    return OMNI_PBR_INPUTS.get(name.removeprefix("inputs:")) if is_omni_pbr else None


def is_preview(prim: Usd.Prim) -> bool:
    """Whether the prim is the UsdPreviewSurface that `define_mdl` puts beside an OmniPBR shader."""
    if prim.GetName() != "PreviewSurface" or prim.GetTypeName() != "Shader":
        return False
    shader = prim.GetParent().GetChild("Shader")
    return bool(shader) and input_type(shader, "diffuse_color_constant") is not None


def show_in_preview(shader: Usd.Prim, name: str) -> None:
    """Copy an input of an OmniPBR shader to the UsdPreviewSurface beside it, if both have it."""
    name = name.removeprefix("inputs:")
    preview = shader.GetParent().GetChild("PreviewSurface") if name in _PREVIEW else Usd.Prim()
    value = shader.GetAttribute(f"inputs:{name}").Get() if preview and is_preview(preview) else None
    if value is not None:
        set_value(UsdShade.Shader(preview).CreateInput(*_PREVIEW[name]).GetAttr(), value)


def is_mdl(prim: Usd.Prim) -> bool:
    """Whether the prim is a material with an MDL surface, or an MDL shader."""
    return _mdl_shader(prim) is not None


def mdl_file(prim: Usd.Prim) -> str:
    """Return the MDL file of a material as it is authored, "" if its surface is not MDL."""
    shader = _mdl_shader(prim)
    return "" if shader is None else str(shader.GetSourceAsset("mdl").path)


def set_input(prim: Usd.Prim, name: str, value: Any) -> None:
    """Set an input of an MDL material (or of its shader), and add it where it is missing.

    Raises:
        AssetNotFound: a texture does not exist.
        BadPrim: OmniPBR has no such input; names near misses.
        BadValue: the input does not take the value.
    """
    shader = _mdl_shader(prim)
    if shader is None:
        raise BadPrim(f"{prim.GetPath()} has no MDL shader, so it has no input {name!r}")
    existing = shader.GetInput(name)
    kind = existing.GetTypeName() if existing else _kind_of(shader, name, value)
    if kind == _T.Asset:
        value = asset_path(value)
    set_value(shader.CreateInput(name, kind).GetAttr(), value)
    show_in_preview(shader.GetPrim(), name)


def _mdl_shader(prim: Usd.Prim) -> UsdShade.Shader | None:
    if prim.IsA(UsdShade.Material):
        source = UsdShade.Material(prim).ComputeSurfaceSource("mdl")
        prim = source[0].GetPrim() if source and source[0] else Usd.Prim()
    if not prim or not prim.IsA(UsdShade.Shader) or not prim.HasAttribute("info:mdl:sourceAsset"):
        return None
    return UsdShade.Shader(prim)


def _identifier(mdl: str) -> str:
    return mdl.replace("\\", "/").rsplit("/", 1)[-1].removesuffix(".mdl")


def _kind_of(shader: UsdShade.Shader, name: str, value: Any) -> Sdf.ValueTypeName:
    identifier = str(shader.GetSourceAssetSubIdentifier("mdl"))
    if name in OMNI_PBR_INPUTS:
        return OMNI_PBR_INPUTS[name]
    if identifier == "OmniPBR":
        near = difflib.get_close_matches(name, OMNI_PBR_INPUTS, 4, 0.5)
        hint = f"did you mean {' or '.join(near)}?" if near else f"it has {', '.join(sorted(OMNI_PBR_INPUTS)[:8])}, ..."
        raise BadPrim(f"{shader.GetPath()}: OmniPBR has no input {name!r}; {hint}")
    # Other MDL modules are not parsed: the type follows from the value.
    if isinstance(value, bool):
        return _T.Bool
    if isinstance(value, (str, Sdf.AssetPath)):
        return _T.Asset
    if isinstance(value, Integral):
        return _T.Int
    if isinstance(value, Real):
        return _T.Float
    return {2: _T.Float2, 3: _T.Color3f, 4: _T.Float4}.get(len(value), _T.FloatArray)
