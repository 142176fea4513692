"""Prims that come and go: only bindings that name one of them are found again, and those are."""

import pytest
from pxr import Sdf, Usd, UsdGeom, UsdLux, UsdShade

from usdsdg_render.sync import gprim_materials
from usdsdg_render.sync.extract import SceneExtractor

RED, BLUE = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
UNBOUND = (0.5, 0.5, 0.5)  # also where the nearest binding names nothing


def add_material(stage, path, color):
    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, f"{path}/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(color)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")


@pytest.fixture
def stage():
    """A red group of two balls."""
    stage = Usd.Stage.CreateInMemory()
    add_material(stage, "/Looks/Red", RED)
    UsdShade.MaterialBindingAPI.Apply(UsdGeom.Xform.Define(stage, "/Group").GetPrim())
    stage.GetPrimAtPath("/Group").CreateRelationship("material:binding", False).SetTargets(["/Looks/Red"])
    for name in ("a", "b"):
        UsdGeom.Sphere.Define(stage, f"/Group/{name}")
    return stage


def bind(stage, path, name, *targets):
    prim = stage.GetPrimAtPath(path)
    UsdShade.MaterialBindingAPI.Apply(prim)
    prim.CreateRelationship(name, False).SetTargets(targets)


def colors(extractor):
    """Base colors of all gprims by path."""
    extractor.update()
    scene = extractor.scene
    rows = scene.materials[scene.material_slots[scene.instances.slot_offset]]
    return dict(zip(scene.instances.paths, map(tuple, rows["base_color"].tolist())))


@pytest.mark.parametrize(
    "add",
    [
        lambda stage: UsdGeom.Cube.Define(stage, "/Box"),
        lambda stage: UsdLux.SphereLight.Define(stage, "/Lamp"),
        lambda stage: add_material(stage, "/Looks/Blue", BLUE),
        lambda stage: stage.RemovePrim("/Group/b"),
    ],
    ids=["a shape", "a light", "a material", "a ball that goes"],
)
def test_what_no_binding_names_lets_the_others_be(add, stage, extractor, monkeypatch):
    bound, read = [], []
    find, read_all = gprim_materials.bound_materials, gprim_materials.MaterialLibrary.at
    monkeypatch.setattr(
        gprim_materials, "bound_materials", lambda prims, owners: [bound.extend(prims), find(prims, owners)][1]
    )
    monkeypatch.setattr(
        gprim_materials.MaterialLibrary, "at", lambda self, path: [read.append(path), read_all(self, path)][1]
    )
    add(stage)
    seen = colors(extractor)
    assert {str(prim.GetPath()) for prim in bound} <= {"/Box"}
    assert not read
    assert seen["/Group/a"] == RED


@pytest.mark.filterwarnings("ignore::usdsdg.errors.UsdsdgWarning")
def test_a_material_that_comes_and_goes_counts_where_a_binding_names_it(stage, extractor):
    bind(stage, "/Group/a", "material:binding", "/Looks/Blue")
    assert colors(extractor) == {"/Group/a": UNBOUND, "/Group/b": RED}
    for _ in range(2):
        add_material(stage, "/Looks/Blue", BLUE)
        assert colors(extractor) == {"/Group/a": BLUE, "/Group/b": RED}
        stage.RemovePrim("/Looks/Blue")
        assert colors(extractor) == {"/Group/a": UNBOUND, "/Group/b": RED}
    stage.RemovePrim("/Looks")
    assert set(colors(extractor).values()) == {UNBOUND}


@pytest.mark.filterwarnings("ignore::usdsdg.errors.UsdsdgWarning")
def test_a_material_that_comes_counts_where_another_relationship_forwards_to_it(stage, extractor):
    holder = stage.DefinePrim("/Holder")
    holder.CreateRelationship("look").SetTargets(["/Looks/Blue"])
    bind(stage, "/Group/a", "material:binding", "/Holder.look")
    colors(extractor)
    add_material(stage, "/Looks/Blue", BLUE)
    assert colors(extractor) == {"/Group/a": BLUE, "/Group/b": RED}
    stage.RemovePrim("/Holder")
    assert colors(extractor)["/Group/a"] == RED  # it forwards to nothing
    stage.DefinePrim("/Holder").CreateRelationship("look").SetTargets(["/Looks/Blue"])
    assert colors(extractor)["/Group/a"] == BLUE


@pytest.mark.filterwarnings("ignore::usdsdg.errors.UsdsdgWarning")
def test_collections_may_include_others_that_come_and_go(stage, extractor):
    add_material(stage, "/Looks/Blue", BLUE)
    Usd.CollectionAPI.Apply(stage.GetPrimAtPath("/Group"), "some").CreateIncludesRel().SetTargets(
        ["/Sets.collection:chosen"]
    )
    bind(stage, "/Group", "material:binding:collection:some", "/Group.collection:some", "/Looks/Blue")
    assert colors(extractor) == {"/Group/a": RED, "/Group/b": RED}
    Usd.CollectionAPI.Apply(stage.DefinePrim("/Sets"), "chosen").IncludePath("/Group/b")
    assert colors(extractor) == {"/Group/a": RED, "/Group/b": BLUE}
    stage.RemovePrim("/Sets")
    assert colors(extractor) == {"/Group/a": RED, "/Group/b": RED}


def test_a_variant_of_an_instance_brings_its_own_material(tmp_path):
    asset = Usd.Stage.CreateNew(str(tmp_path / "asset.usda"))
    root = UsdGeom.Xform.Define(asset, "/Asset").GetPrim()
    asset.SetDefaultPrim(root)
    UsdGeom.Sphere.Define(asset, "/Asset/Ball")
    bind(asset, "/Asset/Ball", "material:binding", "/Asset/Look")
    looks = root.GetVariantSets().AddVariantSet("look")
    for name, color in (("red", RED), ("blue", BLUE)):
        looks.AddVariant(name)
        looks.SetVariantSelection(name)
        with looks.GetVariantEditContext():
            add_material(asset, "/Asset/Look", color)
    stage = Usd.Stage.CreateInMemory()
    for name in ("x", "y"):
        prim = stage.DefinePrim(f"/{name}")
        prim.GetReferences().AddReference(asset.GetRootLayer().identifier)
        prim.SetInstanceable(True)
    extractor = SceneExtractor(stage)
    assert colors(extractor) == {"/x/Ball": BLUE, "/y/Ball": BLUE}
    stage.GetPrimAtPath("/x").GetVariantSet("look").SetVariantSelection("red")
    assert colors(extractor) == {"/x/Ball": RED, "/y/Ball": BLUE}
    looks.SetVariantSelection("red")
    assert colors(extractor) == {"/x/Ball": RED, "/y/Ball": RED}
