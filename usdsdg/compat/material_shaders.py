"""The shaders of materials, and their inputs, as functions of `omni.usd`."""

from __future__ import annotations

from typing import Any

from pxr import Sdf, Usd, UsdShade

from usdsdg.errors import BadPrim
from usdsdg.stage.attributes import set_value
from usdsdg.stage.materials import is_mdl, mdl_file, set_input


def get_shader_from_material(prim: Usd.Prim, get_prim: bool = False) -> Any:
    """Return the surface shader of a material, MDL first; None if there is none.

    Args:
        prim: a UsdShade.Material.
        get_prim: whether to return the shader's prim in place of a UsdShade.Shader.
    """
    material = UsdShade.Material(prim)
    for context in ("mdl", ""):
        source = material.ComputeSurfaceSource(context) if material else None
        if source and source[0]:
            return source[0].GetPrim() if get_prim else source[0]
    return None


def create_material_input(
    prim: Usd.Prim,
    name: str,
    value: Any,
    vtype: Sdf.ValueTypeName,
    def_value: Any = None,
    min_value: Any = None,
    max_value: Any = None,
    display_name: str | None = None,
    display_group: str | None = None,
    color_space: str | None = None,
) -> UsdShade.Input:
    """Set an input of a material's surface shader, and add it where it is missing; return it.

    Args:
        prim: a UsdShade.Material.
        value: of the type `vtype`; of assets a path or URL below the assets root.
        color_space: "raw", "sRGB" or "auto", of textures.

    `def_value`, `min_value`, `max_value`, `display_name` and `display_group` describe the input in an editor, and are
    not kept.

    Raises:
        AssetNotFound: a texture does not exist.
        BadPrim: the material has no surface shader, or OmniPBR has no such input; names near misses.
        BadValue: the input does not take the value.
    """
    shader = get_shader_from_material(prim)
    if shader is None:
        raise BadPrim(f"create_material_input: {prim.GetPath()} is no material with a surface shader")
    if not is_mdl(prim):
        set_value(shader.CreateInput(name, vtype).GetAttr(), value)
    else:
        if mdl_file(prim).rpartition("/")[2] != "OmniPBR.mdl":
            shader.CreateInput(name, vtype)  # MDL modules are not parsed, so the type is the caller's
        set_input(prim, name, value)
    created = shader.GetInput(name)
    if color_space:
        created.GetAttr().SetColorSpace(color_space)
    return created
