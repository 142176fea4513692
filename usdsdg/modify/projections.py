"""Poses and textures of projections: `rep.modify.projection_material`."""

from typing import Any

from pxr import Usd, UsdShade

from usdsdg.arguments.prims import prim_at
from usdsdg.arguments.values import vector
from usdsdg.distribution import draw
from usdsdg.errors import BadPrim
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act
from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.modify import projection_meshes
from usdsdg.modify.texture_groups import TEXTURES, drawn_group, files_of
from usdsdg.stage import materials
from usdsdg.stage.poses.xform_ops import author_pose

_INFLUENCES = {
    "roughness": ("reflection_roughness_texture_influence", 1.0),
    "metallic": ("metallic_texture_influence", 1.0),
    "opacity": ("enable_opacity_texture", True),
}


def projection_material(
    position: Any = None, rotation: Any = None, scale: Any = None, texture_group: Any = None, diffuse: Any = None,
    normal: Any = None, roughness: Any = None, metallic: Any = None, input_prims: Any = None, name: str | None = None,
) -> ReplicatorItem:  # fmt: skip
    """Set the poses of projectors and the textures of projections, and recompute the projection meshes.

    Without arguments the meshes are only recomputed, as is needed after points of a target have changed: what moves is
    followed before each picture.
    See `create.projection_material`.

    Args:
        position: of the projector, in its parent's space [stage units]; as are `rotation` [degrees] and `scale`.
        texture_group: {"diffuse": file, "normal": file, "roughness": file, "metallic": file}, or a distribution over
            such mappings; or what `utils.get_files_group` returns, of which one is drawn for each projection.
        diffuse: a texture, or, with such a drawn group, the suffix that marks it, as "_D"; `normal`, `roughness` and
            `metallic` likewise.

    Raises:
        GraphError: at execution, a texture group has unknown keys, or no texture with a suffix.
        BadPrim: at execution, a prim is not a projection, or it has no OmniPBR material.
    """
    single = dict(diffuse=diffuse, normal=normal, roughness=roughness, metallic=metallic)
    values = dict(position=position, rotation=rotation, scale=scale, texture_group=texture_group, **single)
    return projection_node(values, input_prims, name)


def projection_node(values: dict[str, Any], input_prims: Any, name: str | None = None) -> ReplicatorItem:
    """Add the node of `projection_material`; `values` are its arguments, and `opacity`."""
    values = {**values, "texture_group": drawn_group(values.get("texture_group"))}
    given = {role: value for role, value in values.items() if value is not None}
    return act("OgnModifyProjection", input_prims, name=name, attribute=",".join(given) or "projection", **given)


@action("OgnModifyProjection", "position", "rotation", "scale", "texture_group", *TEXTURES)
def _modify_projection(node: Node, execution: int) -> None:
    drawn = {role: draw(value, node, execution, role) for role, value in node.inputs.items() if role != "attribute"}
    for index, path in enumerate(node.prims):
        values = {role: column[index] for role, column in drawn.items()}
        meshes = projections_at(prim_at(path))
        parts = {
            part: vector(role, values[role])
            for role, part in (("position", "translate"), ("rotation", "rotate_xyz"), ("scale", "scale"))
            if role in values
        }
        single = {role: values[role] for role in TEXTURES if role in values}
        group = files_of(values["texture_group"], single) if "texture_group" in values else single
        for mesh in meshes:
            author_pose(projection_meshes.projector_of(mesh), **parts)
            if group:
                write_textures(_material_of(mesh), group)
            projection_meshes.bake(mesh)


def projections_at(prim: Usd.Prim) -> list[Usd.Prim]:
    """Return the projection meshes at or below a prim.

    Raises:
        BadPrim: there is none.
    """
    found = [each for each in Usd.PrimRange(prim) if each.HasRelationship(projection_meshes.PROJECTOR)]
    if not found:
        raise BadPrim(f"{prim.GetPath()} is not a projection; make one with create.projection_material")
    return found


def _material_of(mesh: Usd.Prim) -> Usd.Prim:
    material, _ = UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()
    if not material:
        raise BadPrim(f"{mesh.GetPath()} has no material whose textures could be changed")
    return material.GetPrim()


def write_textures(material: Usd.Prim, group: dict[str, Any]) -> None:
    """Set the textures of an OmniPBR material, files by what they are for.

    Raises:
        AssetNotFound: a texture does not exist.
    """
    for role, texture in group.items():
        materials.set_input(material, TEXTURES[role], texture)
        if role in _INFLUENCES:
            materials.set_input(material, *_INFLUENCES[role])
        if role == "opacity":
            materials.set_input(material, "enable_opacity", True)
