"""Random colors, textures and materials: `rep.randomizer.color`, `texture` and `materials`."""

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from typing import Any

from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from usdsdg.arguments.prims import prim_at
from usdsdg.arguments.values import vector
from usdsdg.distribution import Distribution, draw_column, is_vector, one_of
from usdsdg.errors import AssetNotFound, GraphError, counted
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act
from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.modify import bind_material
from usdsdg.modify.bound_materials import material_paths
from usdsdg.modify.point_instances import Objects, objects_of, prototypes_or_self
from usdsdg.session.stage_context import current_stage
from usdsdg.stage import assets
from usdsdg.stage.attribute_batch import write_batch
from usdsdg.stage.materials import OMNI_PBR_INPUTS, new_omni_pbr
from usdsdg.stage.scopes import LOOKS


def color(colors: Any, per_sub_mesh: bool = False, seed: int | None = None, input_prims: Any = None) -> ReplicatorItem:
    """Bind to each prim (or, with `per_sub_mesh`, each mesh below it) an OmniPBR material of its own random color.

    The material is below `/Replicator/Looks`, is bound stronger than the bindings of descendants, and is reused at the
    next executions. Instances become ordinary prims.

    Args:
        colors: a distribution, a list of colors to choose from, or one color for all; linear.
        seed: replaces the global seed.

    Raises:
        ArgumentError: `seed` is not an integer, or `colors` is a distribution with another seed.
        GraphError: at execution, a color is not three numbers.
    """
    single = not isinstance(colors, Distribution) and is_vector(colors)
    drawn = colors if single else one_of(colors, seed)
    return _material_node("OgnColor", {"diffuse_color_constant": drawn}, per_sub_mesh, input_prims)


def texture(
    textures: Any, texture_scale: Any = None, texture_rotate: Any = None, per_sub_mesh: bool = False,
    project_uvw: bool = False, seed: int | None = None, input_prims: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Bind to each prim an OmniPBR material with a random texture, as `color` does with a random color.

    Args:
        textures: images to choose from, files or URLs below the assets root, or a distribution over these.
        texture_scale: repetitions along u and v, or one for both; or a list of such values, one for all prims or one
            for each.
        texture_rotate: degrees, or a list of one for all prims or one for each.
        per_sub_mesh: bind a material of its own to each mesh below the prim.
        project_uvw: project the texture along the axes of the object instead of using its UVs.
        seed: replaces the global seed.

    Raises:
        AssetNotFound: an image does not exist; the message names near misses.
        ArgumentError: `seed` is not an integer, or `textures` is a distribution with another seed.
        GraphError: at execution, a list has neither one value nor one for each prim.
    """
    drawn = one_of(textures, seed)
    for path in drawn.node.inputs.get("choices") or []:
        _texture_file(path)
    inputs = {"diffuse_texture": drawn, "texture_scale": texture_scale, "texture_rotate": texture_rotate}
    inputs["project_uvw"] = project_uvw or None
    return _material_node("OgnTexture", inputs, per_sub_mesh, input_prims)


def _texture_file(path: str) -> str:
    from pathlib import Path

    file = assets.resolve(path)
    if not Path(file).is_file():
        raise AssetNotFound(f"randomizer.texture: {path} does not exist")
    return file


def _material_node(kind: str, inputs: dict[str, Any], per_sub_mesh: bool, input_prims: Any) -> ReplicatorItem:
    given = {name: value for name, value in inputs.items() if value is not None}
    return act(kind, input_prims, attribute=",".join(given), perSubMesh=per_sub_mesh or None, **given)


@action("OgnTexture", "texture_scale", "texture_rotate", "project_uvw", "perSubMesh")
@action("OgnColor", "perSubMesh")
def _write_materials(node: Node, execution: int) -> None:
    values = {name: value for name, value in node.inputs.items() if name in _INPUTS}
    if node.inputs.get("perSubMesh"):
        parts = meshes_of(node)
        fixed = {name: value for name, value in values.items() if not isinstance(value, Distribution)}
        values |= {name: parts.spread(_column(name, value, node, execution)) for name, value in fixed.items()}
        node = parts.node
    drawn = {name: _column(name, value, node, execution) for name, value in values.items()}
    shaders: dict[str, UsdShade.Shader] = node.state.setdefault("shaders", {})
    if _write_colors(node, shaders, drawn):
        return
    written = all(path in shaders for path in node.prims)
    if not written:
        _find_or_create_shaders(node.prims, shaders)
    with Sdf.ChangeBlock() if written else nullcontext():
        for index, path in enumerate(node.prims):
            _write_inputs(shaders[path], {name: column[index] for name, column in drawn.items()})


def meshes_of(node: Node) -> Objects:
    """Return the meshes below the prims of a node, each of which gets a material; instances become ordinary prims."""
    for path in node.prims:
        pending = [prim_at(path)]
        while pending:
            prim = pending.pop()
            if prim.IsInstance():
                prim.SetInstanceable(False)
            pending.extend(prim.GetChildren())
    return objects_of(node, [gprims_below(path) for path in node.prims])


def _column(name: str, value: Any, node: Node, execution: int) -> Any:
    """Return a value of an input for each prim. A list of a texture's values has one for all prims or one for each."""
    single = 0 if name == "texture_rotate" else 1  # depth of lists in one value
    if name not in ("texture_scale", "texture_rotate") or _depth(value) <= single:
        return draw_column(value, node, execution, name)
    if len(value) not in (1, len(node.prims)):
        raise GraphError(
            f"randomizer.texture: {name} has {len(value)} values for {counted(len(node.prims), 'prim')}; give one for "
            "all or one for each"
        )
    return list(value) * len(node.prims) if len(value) == 1 else list(value)


def _depth(value: Any) -> int:
    """Return how many lists or tuples a constant is inside of each other."""
    return 1 + _depth(value[0]) if isinstance(value, list | tuple) and len(value) else 0


def _write_colors(node: Node, shaders: dict[str, UsdShade.Shader], drawn: dict[str, Any]) -> bool:
    """Write the colors of existing materials in one batch; return False, writing nothing, in all other cases."""
    if list(drawn) != ["diffuse_color_constant"] or not all(path in shaders for path in node.prims):
        return False
    colors = drawn["diffuse_color_constant"]

    def constants() -> list[Usd.Attribute]:
        name = "inputs:diffuse_color_constant"
        return [shaders[path].GetPrim().GetAttribute(name) for path in node.prims]

    def previews() -> list[Usd.Attribute]:
        bound = [shaders[path].GetPrim().GetParent() for path in node.prims]
        return [each.GetChild("PreviewSurface").GetAttribute("inputs:diffuseColor") for each in bound]

    with Sdf.ChangeBlock():
        return write_batch(node.state, "constants", constants, colors) and write_batch(
            node.state, "previews", previews, colors
        )


def _find_or_create_shaders(paths: Sequence[str], shaders: dict[str, UsdShade.Shader]) -> None:
    """Add the shaders of prims that are not among them yet."""
    for path in paths:
        if path not in shaders and (existing := _existing_shader(path, shaders)):
            shaders[path] = existing
    shaders |= _new_shaders([path for path in dict.fromkeys(paths) if path not in shaders])


def _existing_shader(path: str, taken: Mapping[str, UsdShade.Shader]) -> UsdShade.Shader | None:
    """Return the shader of a material that an earlier run of a saved graph has bound to the prim.

    Clones inherit the binding of their source, and prims may share a material: each needs one of its own then.
    """
    binding = UsdShade.MaterialBindingAPI(prim_at(path)).GetDirectBinding()
    bound, relation = binding.GetMaterialPath(), binding.GetBindingRel()
    if not str(bound).startswith(f"{LOOKS}/") or relation.GetPropertyStack()[0].path != relation.GetPath():
        return None
    shader = bound.AppendChild("Shader")
    if any(each.GetPath() == shader for each in taken.values()):
        return None
    return UsdShade.Shader.Get(current_stage(), shader) or None


def gprims_below(path: str) -> list[str]:
    """Return the paths of the gprims at and below a prim, of a PointInstancer those of its prototypes."""
    roots = [prim_at(each) for own in prototypes_or_self([prim_at(path)]) for each in own]
    return [str(prim.GetPath()) for root in roots for prim in Usd.PrimRange(root) if prim.IsA(UsdGeom.Gprim)]


# The OmniPBR inputs that these randomizers write.
_INPUTS = ("diffuse_color_constant", "diffuse_texture", "texture_scale", "texture_rotate", "project_uvw")


def _new_shaders(paths: Sequence[str]) -> dict[str, UsdShade.Shader]:
    """Create an OmniPBR material for each prim, bind it, and return their MDL shaders by the paths of the prims."""
    stage, made = current_stage(), {}
    for path, material in zip(paths, new_omni_pbr(stage, len(paths)), strict=True):
        prim, omnipbr = prim_at(path), stage.GetPrimAtPath(material)
        if prim.IsInstanceable():
            prim.SetInstanceable(False)
        bind_material(prim, omnipbr, stronger=True)
        made[path] = UsdShade.Shader(omnipbr.GetChild("Shader"))
    return made


def _write_inputs(shader: UsdShade.Shader, values: dict[str, Any]) -> None:
    for name, value in values.items():
        usd_input = shader.CreateInput(name, OMNI_PBR_INPUTS[name])
        if name == "diffuse_color_constant":
            linear = Gf.Vec3f(vector("colors", value))
            usd_input.Set(linear)
            preview = shader.GetPrim().GetParent().GetChild("PreviewSurface")
            preview.GetAttribute("inputs:diffuseColor").Set(linear)
        elif name == "diffuse_texture":
            usd_input.Set(Sdf.AssetPath(_texture_file(value)))
        elif name == "texture_scale":
            usd_input.Set(Gf.Vec2f(vector("texture_scale", value, 2)))
        else:
            usd_input.Set(value)


def materials(
    materials: Any, seed: int | None = None, max_cached_materials: int = 0, input_prims: Any = None,
    name: str | None = None,
) -> ReplicatorItem:  # fmt: skip
    """Bind a random material to each prim, of a PointInstancer to each prototype, as `modify.material` binds it.

    Prims below that have a material of their own keep that, as in Replicator.

    Args:
        materials: items, prims or paths of materials, MDL files or URLs of these, or a distribution over these.
        seed: replaces the global seed.
        max_cached_materials: ignored: all materials are on the stage already and none is ever copied or removed.

    Raises:
        BadPrim: one is not on the stage, or not a material.
        AssetNotFound: there is no such MDL file.
        ArgumentError: `seed` is not an integer, or `materials` is a distribution with another seed.
    """
    if isinstance(materials, Distribution):
        return _binding_node(one_of(materials, seed), input_prims, name)
    return _binding_node(one_of(material_paths(materials), seed), input_prims, name)


def _binding_node(drawn: Distribution, input_prims: Any, name: str | None) -> ReplicatorItem:
    return act("OgnWriteMaterial", input_prims, name=name, value=drawn, perPrototype=True)
