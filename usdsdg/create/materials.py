"""OmniPBR materials: `rep.create.material_omnipbr`."""

from typing import Any

from pxr import Sdf

from usdsdg import modify
from usdsdg.arguments.prims import prim_at
from usdsdg.arguments.values import count_of
from usdsdg.distribution import Distribution, draw
from usdsdg.errors import Unsupported
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act
from usdsdg.graph.node import Node, ReplicatorItem, plain
from usdsdg.modify.numbers import draw_numbers
from usdsdg.session.stage_context import current_stage
from usdsdg.stage import materials


def material_omnipbr(
    diffuse: Any = None, diffuse_texture: Any = None, roughness: Any = None, roughness_texture: Any = None,
    metallic: Any = None, metallic_texture: Any = None, specular: Any = None, emissive_color: Any = None,
    emissive_texture: Any = None, emissive_intensity: Any = 0.0, project_uvw: Any = False, semantics: Any = None,
    count: int = 1,
) -> ReplicatorItem:  # fmt: skip
    """Create `count` OmniPBR materials under `/Replicator/Looks`, with a UsdPreviewSurface beside each shader.

    Every value is one for all materials, a list of one per material, or a distribution, which is sampled again at every
    firing of the enclosing trigger.

    Args:
        diffuse: linear color.
        diffuse_texture: file or URL, as are the other textures. A roughness or metallic texture replaces the constant.
        roughness: 0 (mirror) to 1.
        metallic: 0 to 1.
        specular: OmniPBR's specular level of dielectrics, 0.5 for common plastics.
        emissive_color: linear color.
        emissive_intensity: nits. As it is 0 by default, emission is enabled, and later changes of color and intensity
            are seen; it is not where color, texture and intensity are None.
        project_uvw: project textures along the axes of the object instead of using its UVs.

    Raises:
        ArgumentError: `count` is not an integer or is negative, or a value has the wrong length.
        AssetNotFound: a texture does not exist.
        BadValue: a value has the wrong type.
    """
    inputs = {
        "diffuse_color_constant": diffuse,
        "diffuse_texture": diffuse_texture,
        "reflection_roughness_constant": roughness,
        "reflectionroughness_texture": roughness_texture,
        "reflection_roughness_texture_influence": None if roughness_texture is None else 1.0,
        "metallic_constant": metallic,
        "metallic_texture": metallic_texture,
        "metallic_texture_influence": None if metallic_texture is None else 1.0,
        "specular_level": specular,
        "emissive_color": emissive_color,
        "emissive_color_texture": emissive_texture,
        "emissive_intensity": emissive_intensity,
    }
    if any(each is not None for each in (emissive_color, emissive_texture, emissive_intensity)):
        inputs["enable_emission"] = True
    if isinstance(project_uvw, Distribution) or project_uvw:
        inputs["project_uvw"] = project_uvw
    given = {name: plain(value) for name, value in inputs.items() if value is not None}
    made = materials.new_omni_pbr(current_stage(), count_of(count))
    item = ReplicatorItem(Node(kind="OgnCreateMaterial", prims=tuple(made)))
    now = {name: value for name, value in given.items() if not isinstance(value, Distribution)}
    later = {name: value for name, value in given.items() if name not in now}
    _write_inputs(Node(kind="OgnWriteMaterialInputs", inputs=now, prims=item.prims), 0)
    if later:
        act("OgnWriteMaterialInputs", item, attribute=",".join(later), **later)
    if semantics is not None:
        modify.semantics(semantics, input_prims=item)
    return item


@action("OgnWriteMaterialInputs", *materials.OMNI_PBR_INPUTS)
def _write_inputs(node: Node, execution: int) -> None:
    for name, value in node.inputs.items():
        if name == "attribute":
            continue
        scalar = materials.OMNI_PBR_INPUTS[name] == Sdf.ValueTypeNames.Float
        column = draw_numbers(name, node, execution).tolist() if scalar else draw(value, node, execution, name)
        for path, one in zip(node.prims, column):
            materials.set_input(prim_at(path), name, one)


def mdl_from_json(material_def: Any = None, material_def_path: str | None = None) -> ReplicatorItem:
    """Raise Unsupported: usdsdg does not compile MDL shader graphs."""
    raise Unsupported(
        "create.mdl_from_json: MDL shader graphs are not compiled; use create.material_omnipbr, or "
        "functional.create.material for another MDL module"
    )
