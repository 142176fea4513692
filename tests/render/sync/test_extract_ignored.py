"""What USD leaves out in silence is named: transforms, visibilities and ids that do not count."""

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from usdsdg.errors import UsdsdgWarning, forget_warnings
from usdsdg.stage.geometry.point_ids import point_numbers
from usdsdg_render.sync.extract import SceneExtractor

TRANSLATE = Sdf.ValueTypeNames.Double3


def extract(stage):
    forget_warnings()
    extractor = SceneExtractor(stage)
    extractor.update()
    return extractor.scene


def box(path="/Box"):
    stage = Usd.Stage.CreateInMemory()
    return stage, UsdGeom.Cube.Define(stage, path)


def order(cube, *ops):
    cube.GetPrim().CreateAttribute("xformOpOrder", Sdf.ValueTypeNames.TokenArray, False).Set(Vt.TokenArray(list(ops)))


def test_ops_that_the_order_names_and_the_prim_lacks_are_told():
    stage, cube = box()
    order(cube, "!resetXformStack!", "xformOp:translate", "!invert!xformOp:translate:pivot")
    cube.GetPrim().CreateAttribute("xformOp:translate", TRANSLATE, False).Set(Gf.Vec3d(1, 0, 0))
    with pytest.warns(UsdsdgWarning, match="/Box: its xformOpOrder names !invert!xformOp:translate:pivot, which"):
        extract(stage)


def test_ops_with_names_that_usd_rejects_are_told_once():
    stage, cube = box()
    order(cube, "translate")
    with pytest.warns(UsdsdgWarning) as told:
        assert not len(extract(stage).instances)
    texts = [str(each.message) for each in told if issubclass(each.category, UsdsdgWarning)]
    assert any("/Box: its xformOps cannot be read" in text and "what it places is not drawn" in text for text in texts)
    assert not any("is left out" in text or ".." in text for text in texts)


def test_ops_without_an_order_are_told_and_an_empty_order_is_one(recwarn):
    stage, cube = box()
    cube.GetPrim().CreateAttribute("xformOp:translate", TRANSLATE, False).Set(Gf.Vec3d(1, 0, 0))
    with pytest.warns(UsdsdgWarning, match="/Box: it has xformOp:translate and no xformOpOrder, so it is not moved"):
        extract(stage)
    order(cube)
    recwarn.clear()
    extract(stage)
    assert not [each for each in recwarn if "xformOp" in str(each.message)]


def test_a_visibility_that_usd_does_not_know_is_told():
    stage, cube = box()
    cube.GetVisibilityAttr().Set("hidden")
    assert UsdGeom.Imageable(cube).ComputeVisibility() != UsdGeom.Tokens.invisible
    with pytest.warns(UsdsdgWarning, match="/Box: visibility 'hidden' is neither inherited nor invisible"):
        assert len(extract(stage).instances) == 1


@pytest.mark.parametrize("faces", [[-1], [0, 6]])
def test_holes_in_faces_that_do_not_exist_are_told(faces):
    stage = Usd.Stage.CreateInMemory()
    mesh = UsdGeom.Mesh.Define(stage, "/Mesh")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([3, 3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 0, 2, 3])
    mesh.CreateHoleIndicesAttr(faces)
    with pytest.warns(UsdsdgWarning, match=r"/Mesh: holeIndices names faces that do not exist \(it has 2\)"):
        extract(stage)


def test_ids_that_are_not_one_a_point_are_told():
    stage = Usd.Stage.CreateInMemory()
    instancer = UsdGeom.PointInstancer.Define(stage, "/Points")
    instancer.CreateIdsAttr([5])
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match="/Points: its ids are not one whole number for each of its 2 points"):
        assert point_numbers(instancer, 2, Usd.TimeCode.Default()) == [0, 1]


def test_a_light_of_infinite_intensity_and_a_temperature_is_told_once(recwarn):
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/Light", "SphereLight")
    prim.GetAttribute("inputs:intensity").Set(float("inf"))
    prim.GetAttribute("inputs:enableColorTemperature").Set(True)
    prim.GetAttribute("inputs:colorTemperature").Set(1000.0)
    extract(stage)
    assert ["/Light: intensity" in str(each.message) for each in recwarn] == [True]


@pytest.mark.parametrize("kind", ["Cube", "Xform", "Mesh"])
def test_draw_modes_are_told_of_all_prims(kind):
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.ModelAPI.Apply(stage.DefinePrim("/Model", kind)).CreateModelDrawModeAttr("cards")
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match="/Model: draw mode cards is not supported.* Set model:drawMode to default"):
        extract(stage)


def test_levels_of_detail_are_told():
    stage = Usd.Stage.CreateInMemory()
    root = stage.DefinePrim("/Tree", "Xform")
    root.AddAppliedSchema("LODRootAPI")
    for name in ("Near", "Far"):
        UsdGeom.Sphere.Define(stage, f"/Tree/{name}")
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match="/Tree: LODRootAPI is not supported; all of its levels of detail are drawn"):
        extract(stage)
