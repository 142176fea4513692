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
