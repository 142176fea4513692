"""Physics materials on prims that are no Materials act where they are bound, as in PhysX; elsewhere they are named."""

from __future__ import annotations

import pytest
from pxr import Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from tests.physics.scenes import add, new_stage, physics_material, playing, position, set_value, warnings_of
from tests.sampled_cases import crossed


def _ice(stage: Usd.Stage, path: str, kind: str) -> Usd.Prim:
    """A prim with a material without friction, which it does not share with the other surface."""
    prim = stage.DefinePrim(path, kind)
    api = UsdPhysics.MaterialAPI.Apply(prim)
    api.CreateStaticFrictionAttr(0.0)
    api.CreateDynamicFrictionAttr(0.0)
    prim.CreateAttribute("physxMaterial:frictionCombineMode", Sdf.ValueTypeNames.Token).Set("min")
    return prim


def _bind(prim: Usd.Prim, target: Usd.Prim, *, purpose: str = ":physics", strong: bool = False) -> None:
    relation = prim.CreateRelationship(f"material:binding{purpose}")
    relation.SetTargets([target.GetPath()])
    if strong:
        UsdShade.MaterialBindingAPI.SetMaterialBindingStrength(relation, UsdShade.Tokens.strongerThanDescendants)
    UsdShade.MaterialBindingAPI.Apply(prim)


def _sliding(stage: Usd.Stage, path: str = "/World/box") -> Usd.Prim:
    add(stage, "/World/floor", at=(0, 0, -1), scale=(50, 50, 1), body=False)
    box = add(stage, path, at=(0, 0, 0.1))
    UsdPhysics.RigidBodyAPI(box).CreateVelocityAttr((2, 0, 0))
    return box


@pytest.mark.parametrize(("purpose", "kind"), crossed([":physics", ""], ["Material", "Xform", "Scope", ""]))
def test_a_material_of_any_type_acts_where_it_is_bound(kind, purpose):
    stage = new_stage()
    box = _sliding(stage)
    _bind(box, _ice(stage, "/World/ice", kind), purpose=purpose)
    assert not warnings_of(stage)
    playing(stage).advance(0.5)
    assert position(box)[0] == pytest.approx(1.0, abs=0.01)


def test_the_nearest_binding_counts_unless_one_above_is_stronger():
    for strong, distance in ((False, 1.0), (True, 0.2)):
        stage = new_stage()
        stage.DefinePrim("/World/group", "Xform")
        box = _sliding(stage, "/World/group/box")
        rough = physics_material(stage, "/World/rough", friction=1.0).GetPrim()
        rough.CreateAttribute("physxMaterial:frictionCombineMode", Sdf.ValueTypeNames.Token).Set("max")
        _bind(stage.GetPrimAtPath("/World/group"), rough, strong=strong)
        _bind(box, _ice(stage, "/World/ice", "Xform"))
        playing(stage).advance(0.5)
        assert position(box)[0] == pytest.approx(distance, abs=0.02)


def test_one_that_is_changed_while_playing_acts():
    stage = new_stage()
    box = _sliding(stage)
    ice = _ice(stage, "/World/ice", "Xform")
    _bind(box, ice)
    engine = playing(stage)
    engine.advance(0.25)
    set_value(ice, "physics:dynamicFriction", 0.5)
    set_value(ice, "physics:staticFriction", 0.5)
    engine.advance(1.0)
    assert position(box)[0] == pytest.approx(0.5 + 2.0**2 / (2 * 0.5 * 9.81), abs=0.02)


def test_one_that_is_not_bound_is_named():
    stage = new_stage()
    box = add(stage, "/World/box")
    UsdPhysics.MaterialAPI.Apply(box).CreateDynamicFrictionAttr(0.1)
    physics_material(stage, "/World/material", friction=0.1)
    (message,) = warnings_of(stage)
    assert "these are bound to none: /World/box. Apply PhysicsMaterialAPI to a Material" in message


def _slick(stage: Usd.Stage) -> UsdShade.Material:
    return physics_material(stage, "/World/slick", friction=0.0)


def _bound_to_scene(stage: Usd.Stage) -> Usd.Prim:
    """Bind a material without friction to the PhysicsScene, as Isaac Lab does with its default material."""
    scene = stage.GetPrimAtPath("/PhysicsScene")
    _bind(scene, _slick(stage).GetPrim())
    return scene


def test_a_material_that_is_bound_to_the_scene_is_that_of_colliders_without_one():
    """The floor and the box, a look on which is no physics material, have no friction: v t, not 0.4 m."""
    stage = new_stage()
    box = _sliding(stage)
    look = UsdShade.Material.Define(stage, "/World/look")
    UsdShade.MaterialBindingAPI.Apply(box).Bind(look)
    _bound_to_scene(stage)
    assert not warnings_of(stage)
    playing(stage).advance(0.5)
    assert position(box)[0] == pytest.approx(1.0, abs=0.01)


def test_a_material_of_their_own_is_stronger_than_that_of_the_scene():
    """The mean of 1 on the floor and 0 on the box is 0.5: v² / (2 mu g) = 0.41 m."""
    stage = new_stage()
    box = _sliding(stage)
    _bind(stage.GetPrimAtPath("/World/floor"), physics_material(stage, "/World/rough", friction=1.0).GetPrim())
    _bound_to_scene(stage)
    playing(stage).advance(1.0)
    assert position(box)[0] == pytest.approx(0.408, abs=0.02)


def test_instances_and_bodies_that_are_added_have_the_material_of_the_scene():
    stage = new_stage()
    _sliding(stage)
    _bound_to_scene(stage)
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/many")
    prototype = add(stage, "/World/many/prototype")
    instancer.GetPrototypesRel().SetTargets([prototype.GetPath()])
    instancer.CreateProtoIndicesAttr([0])
    instancer.CreatePositionsAttr([(0, 1, 0.1)])
    instancer.CreateVelocitiesAttr([(2, 0, 0)])
    engine = playing(stage)
    engine.advance(0.5)
    assert instancer.GetPositionsAttr().Get()[0][0] == pytest.approx(1.0, abs=0.01)
    stage.RemovePrim("/World/many")
    engine.advance(0.1)
    late = add(stage, "/World/late", at=(0, -1, 0.1))
    UsdPhysics.RigidBodyAPI(late).CreateVelocityAttr((2, 0, 0))
    engine.advance(0.5)
    assert position(late)[0] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("purpose", [":physics", ""])
def test_binding_one_to_the_scene_while_playing_acts(purpose):
    stage = new_stage()
    box = _sliding(stage)
    slick = _slick(stage).GetPrim()
    engine = playing(stage)
    engine.advance(0.5)
    before = position(box)[0]
    assert before == pytest.approx(0.4, abs=0.02)
    _bind(stage.GetPrimAtPath("/PhysicsScene"), slick, purpose=purpose)
    set_value(box, "physics:velocity", (2, 0, 0))
    engine.advance(0.5)
    assert position(box)[0] - before == pytest.approx(1.0, abs=0.02)
    set_value(slick, "physics:staticFriction", 0.5)
    set_value(slick, "physics:dynamicFriction", 0.5)
    before = position(box)[0]
    set_value(box, "physics:velocity", (2, 0, 0))
    engine.advance(0.5)
    assert position(box)[0] - before == pytest.approx(0.4, abs=0.02)
