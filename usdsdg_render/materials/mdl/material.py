"""Read MDL materials of Omniverse by their names and inputs, without an MDL compiler."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from pxr import Sdf, UsdShade

from usdsdg import errors
from usdsdg_render.images import image_files
from usdsdg_render.materials.mdl.gltf_material import read_gltf
from usdsdg_render.materials.mdl.module import Preset, read_preset
from usdsdg_render.materials.mdl.omni_pbr import read_omni_pbr, read_omni_pbr_clearcoat
from usdsdg_render.materials.mdl.omni_surface import read_omni_glass, read_omni_surface
from usdsdg_render.materials.network import Network
from usdsdg_render.materials.shading import Material


def mdl_name(shader: UsdShade.Shader) -> str:
    """Return the name of the MDL material of a shader, "" if it is not MDL."""
    prim = shader.GetPrim()
    asset = prim.GetAttribute("info:mdl:sourceAsset").Get() if prim.HasAttribute("info:mdl:sourceAsset") else None
    identifier = prim.GetAttribute("info:mdl:sourceAsset:subIdentifier")
    name = str(identifier.Get() or "") if identifier else ""
    if not name and asset is not None and isinstance(asset, Sdf.AssetPath):
        name = asset.path.rsplit("/", 1)[-1].removesuffix(".mdl")
    return name.split("(", 1)[0].rsplit("::", 1)[-1] if asset is not None or name else ""


def mdl_file(shader: UsdShade.Shader) -> str:
    """Return the MDL file of a shader as it is authored, "" if it has none."""
    asset = shader.GetPrim().GetAttribute("info:mdl:sourceAsset").Get()
    return asset.path if isinstance(asset, Sdf.AssetPath) else ""


def read_mdl(network: Network, shader: UsdShade.Shader, name: str) -> Material | None:
    """Read a material whose MDL name is in `_READERS`, or whose file calls such a template; None for others."""
    if name not in _READERS:
        network.preset = _preset(network, shader, name)
        name = "" if network.preset is None else network.preset.template
    reader = _READERS.get(name)
    if reader is None:
        return None
    return replace(reader(network, shader), name=str(network.material.GetPath()))


def _preset(network: Network, shader: UsdShade.Shader, name: str) -> Preset | None:
    attribute = shader.GetPrim().GetAttribute("info:mdl:sourceAsset")
    asset = attribute.Get() if attribute else None
    if asset is None or not isinstance(asset, Sdf.AssetPath):
        return None
    file = asset.resolvedPath
    if not file and "/" in asset.path:  # a bare name is a module that comes with Omniverse
        file = image_files.asset_file(attribute)[1]
    if not file.endswith((".mdl", ".mdl]")):
        return None
    try:
        return read_preset(file, name, shader.GetPath())
    except errors.AssetUnreadable as error:
        network.warn(shader, f"its MDL file cannot be read: {error}")
        return None


_READERS: dict[str, Callable[[Network, UsdShade.Shader], Material]] = {
    "OmniPBR": read_omni_pbr,
    "OmniPBR_Opacity": partial(read_omni_pbr, opacity_enabled=True),
    "OmniPBR_ClearCoat": read_omni_pbr_clearcoat,
    "OmniPBR_ClearCoat_Opacity": partial(read_omni_pbr_clearcoat, opacity_enabled=True),
    "OmniGlass": read_omni_glass,
    "OmniGlass_Opacity": read_omni_glass,
    "OmniSurface": read_omni_surface,
    "OmniSurfaceBase": read_omni_surface,
    "OmniSurfaceLite": read_omni_surface,
    "OmniSurfaceLiteBase": read_omni_surface,
    "gltf_material": read_gltf,
    "pbr": read_gltf,  # gltf/pbr.mdl without a sub-identifier
}
