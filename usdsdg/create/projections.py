"""Projected materials and decals: `rep.create.projection_material` and `mesh_decal`."""

from typing import Any

from pxr import Sdf, Usd

from usdsdg import modify
from usdsdg.arguments.prims import prim_at
from usdsdg.arguments.values import vector
from usdsdg.create.materials import material_omnipbr
from usdsdg.create.objects import new_object, new_xform
from usdsdg.distribution import Distribution
from usdsdg.errors import ArgumentError, Unsupported, counted
from usdsdg.graph.node import Node, ReplicatorItem, current_prims, current_trigger, prim_paths
from usdsdg.modify import projection_meshes
from usdsdg.modify.projections import projection_node, write_textures
from usdsdg.modify.texture_groups import drawn_group, files_of
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.poses import transforms
from usdsdg.stage.poses.xform_ops import author_pose


def projection_material(
    proxy_prim: Any, semantics: Any = None, material: Any = None, offset_scale: float = 0.01, input_prims: Any = None,
    name: str | None = None,
) -> ReplicatorItem:  # fmt: skip
    """Project a material onto prims, as a mesh `/Replicator/Projection_Xform/Projection` over the covered surface.

    The box of `proxy_prim` is projected along its -X onto all front-facing faces of the targets inside the box; U runs
    against the box's Z and V along its Y. The mesh is computed when this line runs, again before
    each picture for which projector or targets have moved, and by `modify.projection_material`.

    Args:
        proxy_prim: the projector; without geometry its box is a meter in size. One projects onto all targets; of
            several there are as many as targets, or a multiple, and each projects onto one, the targets in turn.
        semantics: labels of each projection.
        material: the projected material; a new OmniPBR material for each by default.
        offset_scale: distance above the surface, as a fraction of the size of the projector's box.
        input_prims: targets; by default those of the enclosing `with`.

    Raises:
        ArgumentError: there is no target, no projector, or another number of these.
        BadPrim: a prim is not on the stage.
    """
    proxies, targets = prim_paths(proxy_prim), _outermost(prim_paths(input_prims) or current_prims())
    if not proxies or not targets or (len(proxies) > 1 and len(proxies) % len(targets)):
        raise ArgumentError(
            f"create.projection_material: {counted(len(proxies), 'projector')} and {counted(len(targets), 'target')}; "
            "give one projector as proxy_prim, or as many as targets or a multiple, and targets as input_prims or by "
            "`with`"
        )
    made = []
    for index, projector in enumerate(map(prim_at, proxies)):
        covered = targets if len(proxies) == 1 else (targets[index % len(targets)],)
        offset = offset_scale * projection_meshes.size_of(projector)
        one = _projected(projector, covered, name, offset=offset, axis="X")
        _bind_and_label(one, material, semantics)
        made += one.prims
    item = ReplicatorItem(Node(kind="OgnCreateProjection", prims=tuple(made), name=name))
    if current_trigger() is not None:
        modify.projection_material(input_prims=item)
    return item


def follow() -> None:
    """Recompute the projections whose projector or targets have moved since; see `projection_meshes.follow`."""
    projection_meshes.follow()


def _outermost(targets: tuple[str, ...]) -> tuple[str, ...]:
    """Return targets without those below others, which a search by path finds too: faces would be covered twice."""
    kept = set(Sdf.Path.RemoveDescendentPaths([Sdf.Path(path) for path in targets]))
    return tuple(path for path in targets if Sdf.Path(path) in kept)


def _projected(projector: Usd.Prim, targets: tuple[str, ...], name: str | None, **how: Any) -> ReplicatorItem:
    path, child = new_object("Projection", name, None)
    projection_meshes.define(current_stage(), child, projector, [prim_at(path) for path in targets], **how)
    return ReplicatorItem(Node(kind="OgnCreateProjection", prims=(path,), name=name))


def _bind_and_label(item: ReplicatorItem, material: Any, semantics: Any) -> None:
    modify.material(material if material is not None else material_omnipbr(), input_prims=item)
    if semantics is not None:
        modify.semantics(semantics, input_prims=item)


def mesh_decal(
    decal: Any = None, material: Any = None, texture_group: Any = None, diffuse: Any = None, normal: Any = None,
    roughness: Any = None, metallic: Any = None, opacity: Any = None, semantics: Any = None,
    position: Any = (0, 0, 0), rotation: Any = None, scale: Any = (1, 1, 1), offset_normal: float = 0.1,
    offset_depth: float = 0.0, input_prims: Any = None, name: str | None = None,
) -> ReplicatorItem:  # fmt: skip
    """Project textures or a material onto prims as `projection_material` does, with a projector of its own.

    The projector is an Xform `/Replicator/DecalProjector_Xform...` with the given pose; its box, a meter times `scale`,
    is projected along its -Z, with UVs over its X and Y. Pose and textures may be distributions, which are sampled
    again at every firing.

    Args:
        material: the projected material, instead of textures.
        texture_group: {"diffuse": file, ...} or a distribution over such mappings; or what `utils.get_files_group`
            returns, with the suffixes in place of single textures, as in diffuse="_D".
        position: of the projector's center in the world [stage units].
        rotation: of the projector [degrees].
        scale: of the projector's box.
        offset_normal: distance above the surface [centimeters].
        offset_depth: shift of the projector along its Z [stage units].

    Raises:
        ArgumentError: there is no target; or `material` with textures.
        Unsupported: `decal` (an existing decal mesh); give textures or a material.
    """
    if decal is not None:
        raise Unsupported("create.mesh_decal: decal is not available; give texture_group, textures or material")
    if isinstance(opacity, Distribution):
        raise Unsupported("create.mesh_decal: opacity cannot be a distribution; put it into texture_group")
    targets = _outermost(prim_paths(input_prims) or current_prims())
    single = dict(diffuse=diffuse, normal=normal, roughness=roughness, metallic=metallic, opacity=opacity)
    textures = {role: value for role, value in single.items() if value is not None}
    texture_group = drawn_group(texture_group)
    if not targets or (material is not None and (textures or texture_group is not None)):
        raise ArgumentError(
            f"create.mesh_decal: {len(targets)} targets; give some as input_prims or by `with`, and one of material "
            "and textures"
        )
    pose = dict(position=position, rotation=rotation, scale=scale)
    pose = {role: value for role, value in pose.items() if value is not None}
    offset = offset_normal * 0.01 / transforms.meters_per_unit(current_stage())
    item = _projected(_projector(pose), targets, name or "Decal", offset=offset, depth=offset_depth)
    bound = material if material is not None else material_omnipbr()
    _bind_and_label(item, bound, semantics)
    if texture_group is None:
        given = textures
    else:
        given = {} if isinstance(texture_group, Distribution) else files_of(texture_group, textures)
    drawn: dict[str, Any] = {
        role: value for role, value in {**pose, **given}.items() if isinstance(value, Distribution)
    }
    if constant := {role: value for role, value in given.items() if role not in drawn}:
        write_textures(prim_at(prim_paths(bound)[0]), constant)
    if isinstance(texture_group, Distribution):
        drawn |= textures | {"texture_group": texture_group}
    if drawn or current_trigger() is not None:
        projection_node(drawn, item)
    return item


def _projector(pose: dict[str, Any]) -> Usd.Prim:
    prim = new_xform("DecalProjector_Xform", None)
    names = {"position": "translate", "rotation": "rotate_xyz", "scale": "scale"}
    constant = {role: value for role, value in pose.items() if not isinstance(value, Distribution)}
    author_pose(prim, **{names[role]: vector(role, value) for role, value in constant.items()})
    return prim
