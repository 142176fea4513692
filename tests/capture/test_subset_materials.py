"""Materials and labels of GeomSubsets: which faces labels show, also of prototypes and after edits between frames."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdShade

import usdsdg as rep
from usdsdg.session.settings.store import get_settings
from usdsdg.stage.semantics.labels import add_labels

SIZE = (32, 32)


def material(stage, name, opacity):
    found = UsdShade.Material.Define(stage, f"/Looks/{name}")
    shader = UsdShade.Shader.Define(stage, f"/Looks/{name}/Shader")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(opacity)
    found.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return found


@pytest.fixture(params=["mesh", "reference", "scene instance", "point instance"])
def subset(request, stage):
    """One of the two faces of a mesh, each 8 x 16 pixels, with a material of opacity 0; the mesh has one of 1."""
    UsdGeom.SetStageUpAxis(stage, "Z")
    clear, full = material(stage, "Clear", 0.0), material(stage, "Full", 1.0)
    root = "/World/Thing"
    if request.param == "mesh":
        UsdGeom.Xform.Define(stage, root)
    else:
        stage.CreateClassPrim("/Library")
        UsdGeom.Xform.Define(stage, "/Library/Asset")
        root = "/Library/Asset"
    mesh = UsdGeom.Mesh.Define(stage, f"{root}/Mesh")
    mesh.CreatePointsAttr([Gf.Vec3f(x, y, 0) for x in (-1, 0, 1) for y in (-1, 1)])
    mesh.CreateFaceVertexCountsAttr([4, 4])
    mesh.CreateFaceVertexIndicesAttr([0, 2, 3, 1, 2, 4, 5, 3])
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(full)
    subset = UsdGeom.Subset.Define(stage, f"{root}/Mesh/Half")
    subset.CreateElementTypeAttr("face")
    subset.CreateIndicesAttr([1])
    subset.CreateFamilyNameAttr("materialBind")
    UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(clear)
    if request.param == "point instance":
        instancer = UsdGeom.PointInstancer.Define(stage, "/World/Thing")
        instancer.CreatePrototypesRel().SetTargets([root])
        instancer.CreateProtoIndicesAttr([0])
        instancer.CreatePositionsAttr([Gf.Vec3f(0)])
    elif request.param != "mesh":
        thing = stage.DefinePrim("/World/Thing", "Xform")
        thing.GetReferences().AddInternalReference(root)
        thing.SetInstanceable(request.param == "scene instance")
    return UsdShade.MaterialBindingAPI(subset)


def orthographic(stage):
    """A camera above, with 8 pixels a unit."""
    camera = UsdGeom.Camera.Define(stage, "/Camera")
    camera.CreateProjectionAttr("orthographic")
    camera.CreateHorizontalApertureAttr(40.0)
    camera.AddTranslateOp().Set(Gf.Vec3d(0, 0, 10))
    return "/Camera"


@pytest.fixture
def seen(stage):
    """A function that captures a frame and returns how many pixels on the left and on the right show the mesh."""
    depth = rep.annotators.get("distance_to_camera").attach(rep.create.render_product(orthographic(stage), SIZE))

    def count():
        rep.orchestrator.step(delta_time=0.0)
        hit = np.isfinite(depth.get_data())
        return int(hit[:, :16].sum()), int(hit[:, 16:].sum())

    return count


@pytest.mark.parametrize(
    "edit",
    [
        lambda binding: binding.Bind(UsdShade.Material.Get(binding.GetPrim().GetStage(), "/Looks/Full")),
        lambda binding: binding.UnbindAllBindings(),
        lambda binding: binding.GetDirectBindingRel().ClearTargets(True),
    ],
    ids=["bound to another", "unbound", "cleared"],
)
def test_faces_show_the_material_that_is_bound_now(subset, seen, edit):
    assert seen() == (128, 0)
    edit(subset)
    assert seen() == (128, 128)
    subset.Bind(UsdShade.Material.Get(subset.GetPrim().GetStage(), "/Looks/Clear"))
    assert seen() == (128, 0)


@pytest.fixture
def _told_apart(stage):
    get_settings().set("/syntheticdata/sensors/perSubsetSegmentation", True)
    yield
    get_settings().set("/syntheticdata/sensors/perSubsetSegmentation", False)


@pytest.mark.usefixtures("_told_apart")
def test_labels_of_subsets_count_in_prototypes_too(subset, stage):
    subset.UnbindAllBindings()
    add_labels(subset.GetPrim().GetParent(), {"class": ["left"]})
    add_labels(subset.GetPrim(), {"class": ["right"]})
    camera = orthographic(stage)
    masks = rep.annotators.get("semantic_segmentation").attach(rep.create.render_product(camera, SIZE))
    rep.orchestrator.step(delta_time=0.0)
    data, names = masks.get_data()["data"], masks.get_data()["info"]["idToLabels"]
    for half, label in ((data[8:24, 8:16], "left"), (data[8:24, 16:24], "left,right")):
        assert {names[str(number)]["class"] for number in np.unique(half)} == {label}
