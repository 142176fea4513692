"""Commands that create and bind materials."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import PurePosixPath

from pxr import Sdf, Usd, UsdGeom, UsdShade

from usdsdg.compat.omni.kit.commands.registry import command
from usdsdg.errors import ArgumentError, BadPrim, counted
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.materials import define_mdl
from usdsdg.stage.paths import next_free_path

AnyPath = str | Sdf.Path

_COLOR = Sdf.ValueTypeNames.Color3f
_TOKEN = Sdf.ValueTypeNames.Token


@command("CreateMdlMaterialPrim")
def create_mdl_material_prim(
    mtl_url: str, mtl_name: str, mtl_path: AnyPath, select_new_prim: bool = False, stage: Usd.Stage | None = None
) -> str:
    """Define a material whose shader is `mtl_name` of an MDL file; return its path."""
    target = stage or current_stage()
    path = next_free_path(target, str(mtl_path))
    _define_scope(target, path)
    material = define_mdl(target, path, mtl_url)
    UsdShade.Shader(target.GetPrimAtPath(f"{path}/Shader")).SetSourceAssetSubIdentifier(mtl_name, "mdl")
    if select_new_prim:
        current().selection.set_selected_prim_paths([path])
    return str(material.GetPath())


@command("CreateAndBindMdlMaterialFromLibrary")
def create_and_bind_mdl_material(
    mdl_name: str,
    mtl_name: str = "",
    prim_name: str | None = None,
    mtl_created_list: list[str] | None = None,
    bind_selected_prims: Sequence[AnyPath] | None = None,
    select_new_prim: bool = True,
) -> str:
    """Define a material of an MDL file below `Looks` of the default prim, bound to the selected prims; return its path.

    Args:
        mtl_created_list: The path is appended to it.
        bind_selected_prims: Bind to these prims instead.
    """
    stage = current_stage()
    name = mtl_name or PurePosixPath(mdl_name).stem
    root = stage.GetDefaultPrim().GetPath() if stage.GetDefaultPrim() else Sdf.Path.absoluteRootPath
    path = create_mdl_material_prim(mdl_name, name, root.AppendPath(f"Looks/{prim_name or name}"))
    if mtl_created_list is not None:
        mtl_created_list.append(path)
    selected = current().selection.get_selected_prim_paths() if bind_selected_prims is None else bind_selected_prims
    bind_material(list(selected), path)
    if select_new_prim:
        current().selection.set_selected_prim_paths([path])
    return path


@command("CreatePreviewSurfaceTextureMaterialPrim")
def create_preview_surface_texture_material_prim(
    mtl_path: AnyPath, select_new_prim: bool = False, stage: Usd.Stage | None = None
) -> str:
    """Define a material with a UsdPreviewSurface whose diffuse color is a texture, to be set; return its path."""
    target = stage or current_stage()
    path = create_preview_surface_material_prim(mtl_path, select_new_prim, target)
    reader, texture = (UsdShade.Shader.Define(target, f"{path}/{name}") for name in ("st", "diffuseColorTex"))
    reader.CreateIdAttr("UsdPrimvarReader_float2")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset)
    texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(
        reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
    )
    UsdShade.Shader.Get(target, f"{path}/Shader").CreateInput("diffuseColor", _COLOR).ConnectToSource(
        texture.CreateOutput("rgb", _COLOR)
    )
    return path


@command("CreatePreviewSurfaceMaterialPrim")
def create_preview_surface_material_prim(
    mtl_path: AnyPath, select_new_prim: bool = False, stage: Usd.Stage | None = None
) -> str:
    """Define a material with a UsdPreviewSurface; return its path."""
    target = stage or current_stage()
    path = next_free_path(target, str(mtl_path))
    _define_scope(target, path)
    material = UsdShade.Material.Define(target, path)
    shader = UsdShade.Shader.Define(target, f"{path}/Shader")
    shader.CreateIdAttr("UsdPreviewSurface")
    material.CreateSurfaceOutput().ConnectToSource(shader.CreateOutput("surface", _TOKEN))
    if select_new_prim:
        current().selection.set_selected_prim_paths([path])
    return path


@command("BindMaterial")
def bind_material(
    prim_path: AnyPath | Sequence[AnyPath],
    material_path: AnyPath,
    strength: str | Sequence[str] | None = None,
    material_purpose: str = "",
    stage: Usd.Stage | None = None,
) -> None:
    """Bind a material to prims; the path "" or "None" unbinds.

    strength: of all bindings, or a list with one for all or one for each prim, as Kit's command log has it.

    Raises:
        BadPrim: a prim or the material is not on the stage.
        ArgumentError: the list of strengths has another length than that of the prims.
    """
    target = stage or current_stage()
    material = UsdShade.Material(target.GetPrimAtPath(str(material_path))) if str(material_path) else None
    unbind = str(material_path) in ("", "None")
    if not unbind and not material:
        raise BadPrim(f"BindMaterial: {material_path} is not a material on the stage")
    paths = [prim_path] if isinstance(prim_path, (str, Sdf.Path)) else list(prim_path)
    for path, one in zip(paths, _strengths(strength, len(paths))):
        prim = target.GetPrimAtPath(str(path))
        if not prim:
            raise BadPrim(f"BindMaterial: {path} is not on the stage")
        binding = UsdShade.MaterialBindingAPI.Apply(prim)
        if unbind:
            binding.UnbindDirectBinding(material_purpose)
        else:
            binding.Bind(material, one or UsdShade.Tokens.weakerThanDescendants, material_purpose)


def _strengths(given: str | Sequence[str] | None, count: int) -> Sequence[str | None]:
    if given is None or isinstance(given, str):
        return [given] * count
    if len(given) not in (1, count):
        raise ArgumentError(
            f"BindMaterial: strength has {len(given)} entries for {counted(count, 'prim')}; give one, or one for each"
        )
    return list(given) * count if len(given) == 1 else list(given)


def _define_scope(stage: Usd.Stage, path: str) -> None:
    parent = Sdf.Path(path).GetParentPath()
    if parent != Sdf.Path.absoluteRootPath and not stage.GetPrimAtPath(parent):
        UsdGeom.Scope.Define(stage, parent)
