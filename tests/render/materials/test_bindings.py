"""Bindings that give no material are named, with what is wrong with them."""

import pytest
from pxr import Sdf, Usd, UsdGeom, UsdShade

from usdsdg_render.materials.bindings import bound_materials

RED = Sdf.Path("/Looks/Red")
COLLECTION = Sdf.Path("/Group.collection:balls")


def grouped(targets, *, schema=True):
    """A ball below a group that binds its collection `balls` to what `targets` names."""
    stage = Usd.Stage.CreateInMemory()
    group, ball = UsdGeom.Xform.Define(stage, "/Group").GetPrim(), UsdGeom.Sphere.Define(stage, "/Group/Ball").GetPrim()
    UsdShade.Material.Define(stage, RED)
    UsdShade.MaterialBindingAPI.Apply(group)
    if schema:
        Usd.CollectionAPI.Apply(group, "balls").IncludePath(ball.GetPath())
    group.CreateRelationship("material:binding:collection:some", False).SetTargets(targets)
    return stage, ball


def test_a_collection_binds_its_members():
    stage, ball = grouped([COLLECTION, RED])
    assert [prim.GetPath() for prim in bound_materials([ball]) if prim] == [RED]
    assert stage


@pytest.mark.parametrize(
    ("targets", "schema", "said"),
    [
        ([COLLECTION, Sdf.Path("/Looks/Gone")], True, "its material /Looks/Gone does not exist"),
        ([COLLECTION, RED], False, "the collection /Group.collection:balls does not exist"),
        ([RED], True, "names /Looks/Red in place of a collection and a material"),
    ],
)
def test_bindings_of_collections_that_give_nothing_are_named(targets, schema, said):
    stage, ball = grouped(targets, schema=schema)
    with pytest.warns(UserWarning, match=f"/Group: .*{said}.* Correct material:binding:collection:some"):
        assert bound_materials([ball]) == [None]
    assert stage


@pytest.mark.parametrize("purpose", ["full", "preview"])
def test_missing_materials_of_a_purpose_are_named(purpose):
    stage = Usd.Stage.CreateInMemory()
    ball = UsdGeom.Sphere.Define(stage, "/Ball").GetPrim()
    UsdShade.MaterialBindingAPI.Apply(ball)
    ball.CreateRelationship(f"material:binding:{purpose}", False).SetTargets(["/Looks/Gone"])
    with pytest.warns(UserWarning, match=f"/Ball: its material /Looks/Gone .* Correct material:binding:{purpose}"):
        assert bound_materials([ball]) == [None]


def bound_twice(first, second, *, on_child):
    """A ball that two bindings name materials for, the second one of the child or of its parent."""
    stage = Usd.Stage.CreateInMemory()
    group, ball = UsdGeom.Xform.Define(stage, "/Group").GetPrim(), UsdGeom.Sphere.Define(stage, "/Group/Ball").GetPrim()
    UsdShade.Material.Define(stage, RED)
    for prim, (name, target) in ((group, first), (ball if on_child else group, second)):
        UsdShade.MaterialBindingAPI.Apply(prim)
        prim.CreateRelationship(name, False).SetTargets([target])
    return stage, ball


GONE = Sdf.Path("/Looks/Gone")


@pytest.mark.parametrize(
    ("first", "second", "on_child", "named"),
    [
        (("material:binding", RED), ("material:binding:full", GONE), False, "/Group: .*material:binding:full"),
        (("material:binding:full", GONE), ("material:binding", RED), True, "/Group: .*material:binding:full"),
        (("material:binding:preview", RED), ("material:binding", GONE), True, "/Group/Ball: .*material:binding"),
    ],
)
def test_a_missing_material_in_whose_place_another_binding_counts_is_named(first, second, on_child, named):
    stage, ball = bound_twice(first, second, on_child=on_child)
    said = ": its material /Looks/Gone does not exist; another .*Correct "
    with pytest.warns(UserWarning, match=named.replace(": .*", said)):
        assert [prim.GetPath() for prim in bound_materials([ball]) if prim] == [RED]
    assert stage


def test_a_missing_material_that_another_binding_precedes_is_not_named(recwarn):
    stage, ball = bound_twice(("material:binding", GONE), ("material:binding:full", RED), on_child=True)
    assert [prim.GetPath() for prim in bound_materials([ball]) if prim] == [RED]
    assert stage
    assert not list(recwarn)
