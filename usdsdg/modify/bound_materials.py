"""Materials that are bound to prims: `rep.modify.material`."""

from collections.abc import Mapping
from typing import Any

from pxr import Usd, UsdGeom, UsdShade

from usdsdg.arguments.prims import prim_at
from usdsdg.arguments.values import shown
from usdsdg.distribution import Distribution, draw, one_of, options_of
from usdsdg.errors import ArgumentError, BadPrim, warn_once
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act, act_now
from usdsdg.graph.label_sources import LabelSources, brings_labels
from usdsdg.graph.node import Node, ReplicatorItem, current_prims, prim_paths
from usdsdg.modify.mdl_materials import is_mdl, mdl_material
from usdsdg.modify.point_instances import objects_of, prototypes_or_self
from usdsdg.modify.prims import target_prims


def material(value: Any, input_prims: Any = None, name: str | None = None) -> ReplicatorItem:
    """Bind a material. As in Replicator, prims below that have a material of their own keep that; it is warned of.

    Args:
        value: path, prim or item of a material, or an MDL file (see `mdl_material`); a list of these, of which one is
            drawn for each prim; an item with as many materials as prims, one for each; or a distribution over these.

    Raises:
        BadPrim: it is not on the stage, or not a material.
        AssetNotFound: there is no such MDL file.
        ArgumentError: it is None or empty.
        GraphError: at execution, a distribution has sampled such a value.
    """
    if isinstance(value, Distribution):
        return act("OgnWriteMaterial", input_prims, name=name, value=value)
    listed = material_paths(value)
    if not listed:
        raise ArgumentError(f"modify.material: value is {shown(value)}; give at least one material")
    if len(listed) < 2 or (isinstance(value, ReplicatorItem) and len(listed) == _count_of(input_prims)):
        return bind_each(listed[0] if len(listed) == 1 else listed, input_prims)
    return act("OgnWriteMaterial", input_prims, name=name, value=one_of(listed, None))


def bind_each(value: Any, input_prims: Any) -> ReplicatorItem:
    """Bind one material to all prims, or those of a list to one each; at once, or in a trigger when it fires."""
    return act_now("OgnWriteMaterial", input_prims, value=value)


def _count_of(input_prims: Any) -> int:
    return len(prim_paths(input_prims) or current_prims())


def material_paths(value: Any) -> list[str]:
    """Return the paths of materials that an argument names, those of MDL files included, which are added to the stage.

    Raises:
        BadPrim: one is not on the stage, or not a material.
        AssetNotFound: there is no such MDL file.
    """
    found = [str(mdl_material(each).GetPath()) if is_mdl(each) else each for each in prim_paths(value)]
    for path in found:
        check_material(prim_at(path))
    return found


@action("OgnWriteMaterial")
def _write_material(node: Node, execution: int) -> None:
    warned: set[str] = node.state.setdefault("warned", set())
    if node.inputs.get("perPrototype"):
        node = objects_of(node, prototypes_or_self(target_prims(node))).node
    bound = {}
    for path, chosen in zip(node.prims, draw(node.inputs["value"], node, execution, "value")):
        bound[path] = mdl_material(chosen) if is_mdl(chosen) else prim_at(prim_paths(chosen)[0])
        bind_material(prim_at(path), bound[path])
    for path in sorted(bound.keys() - warned):
        _warn_if_hidden(prim_at(path), bound)
    warned.update(bound)


def _warn_if_hidden(prim: Usd.Prim, targets: Mapping[str, Usd.Prim]) -> None:
    """Warn of a prim below which no shape shows the material that was bound to it."""
    below = [each for each in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()) if each.IsA(UsdGeom.Gprim)]
    for shape in below:
        nearest = next(path for path in reversed(shape.GetPath().GetPrefixes()) if str(path) in targets)
        shown = UsdShade.MaterialBindingAPI(shape).ComputeBoundMaterial()[0]
        if nearest != prim.GetPath() or not shown or shown.GetPath() == targets[str(nearest)].GetPath():
            return
    if below:
        warn_once(
            f"{prim.GetPath()}: the material that is bound to it has no effect, since what is below has materials of "
            f"its own, such as {below[0].GetPath()}, and these win, as in Replicator. Give the shapes, as by "
            'rep.get.prims(path_match=..., prim_types=["Mesh"]), or use randomizer.color or texture, which are bound '
            "stronger"
        )


@brings_labels("OgnWriteMaterial")
def _materials_to_bind(node: Node, sources: LabelSources) -> None:
    options = [each for each in options_of(node.inputs["value"]) if not is_mdl(each)]
    bound = [path for each in options for path in prim_paths(each)]
    prims = [prim_at(path) for path in node.prims]
    names = prototypes_or_self(prims) if node.inputs.get("perPrototype") else [node.prims]
    for path in (path for own in names for path in own):
        sources.add_materials(path, bound)


def bind_material(prim: Usd.Prim, bound: Usd.Prim, *, stronger: bool = False) -> None:
    """Bind a material; `stronger` than the bindings of descendants, which win otherwise.

    Raises:
        BadPrim: `bound` is not a material.
    """
    check_material(bound)
    strength = UsdShade.Tokens.strongerThanDescendants if stronger else UsdShade.Tokens.fallbackStrength
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(UsdShade.Material(bound), strength)


def check_material(prim: Usd.Prim) -> None:
    """Raise BadPrim for a prim that is not a material."""
    if not prim.IsA(UsdShade.Material):
        raise BadPrim(f"{prim.GetPath()} is a {prim.GetTypeName() or 'prim without a type'}, not a Material")
