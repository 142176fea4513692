"""Physics materials. Mirrors `rep.physics.physics_material`."""

from typing import Any

from pxr import Usd, UsdPhysics, UsdShade

from usdsdg.arguments.prims import prim_at
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act
from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.modify.numbers import draw_numbers


def physics_material(
    static_friction: Any = None, dynamic_friction: Any = None, restitution: Any = None, input_prims: Any = None
) -> ReplicatorItem:
    """Author the physics material of each prim, or of prims that are materials, at each execution.

    A prim without one gets `<prim>/PhysicsMaterial`, bound weaker than its descendants' own. A material that several
    prims share changes for all of them.

    Args:
        static_friction: coefficient, as is `dynamic_friction`.
        restitution: 0 (no bounce) to 1.
    """
    values = dict(static_friction=static_friction, dynamic_friction=dynamic_friction, restitution=restitution)
    item = act("OgnPhysicsMaterial", input_prims, attribute="physics:material", **values)
    for path in item.prims:
        _physics_material(prim_at(path))
    return item


def _physics_material(prim: Usd.Prim) -> UsdPhysics.MaterialAPI:
    """Return the physics material that a prim is, or that is bound to it; create and bind one where there is none."""
    if prim.IsA(UsdShade.Material):
        return UsdPhysics.MaterialAPI.Apply(prim)
    material, binding = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")
    if material and (material.GetPrim().HasAPI(UsdPhysics.MaterialAPI) or binding.GetName().endswith(":physics")):
        return UsdPhysics.MaterialAPI.Apply(material.GetPrim())
    made = UsdShade.Material.Define(prim.GetStage(), prim.GetPath().AppendChild("PhysicsMaterial"))
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(made, UsdShade.Tokens.weakerThanDescendants, "physics")
    return UsdPhysics.MaterialAPI.Apply(made.GetPrim())


@action("OgnPhysicsMaterial", "static_friction", "dynamic_friction", "restitution")
def _write_physics_material(node: Node, execution: int) -> None:
    roles = [role for role in ("static_friction", "dynamic_friction", "restitution") if role in node.inputs]
    columns = {role: draw_numbers(role, node, execution) for role in roles}
    for index, path in enumerate(node.prims):
        api = _physics_material(prim_at(path))
        setters = {
            "static_friction": api.CreateStaticFrictionAttr,
            "dynamic_friction": api.CreateDynamicFrictionAttr,
            "restitution": api.CreateRestitutionAttr,
        }
        for role, column in columns.items():
            setters[role]().Set(float(column[index]))
