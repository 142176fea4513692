"""Splines and value clips move what is drawn as time samples do; pxr's own values are the oracle."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Ts, Usd, UsdGeom, Vt

from tests.render.sync.test_extract_scene import make_stage
from usdsdg_render.sync.extract import SceneExtractor

CLIP = """#usda 1.0
def Xform "M"
{
    double3 xformOp:translate.timeSamples = {0: (0, 0, 0), 24: (2, 0, 0)}
}
"""


def at(extractor, code):
    extractor.update(Usd.TimeCode(code))
    return extractor.scene


def spline(first, last):
    made = Ts.Spline("double")
    for code, number in ((0, first), (24, last)):
        made.SetKnot(Ts.Knot(typeName="double", time=code, value=float(number), nextInterp=Ts.InterpLinear))
    return made


def clips_of(folder, *, template):
    """Clips that move a prim at /M, in a file that is not open yet."""
    (folder / "clip.001.usda").write_text(CLIP)
    if template:
        file = str(folder / "clip.###.usda")
        made = {"templateStartTime": 1.0, "templateEndTime": 1.0, "templateStride": 1.0, "templateAssetPath": file}
    else:
        file = Sdf.AssetPath(str(folder / "clip.001.usda"))
        made = {"assetPaths": Sdf.AssetPathArray([file]), "manifestAssetPath": file}
        made |= {"active": Vt.Vec2dArray([(0, 0)]), "times": Vt.Vec2dArray([(0, 0), (24, 24)])}
    return {"default": {"primPath": "/M", **made}}


@pytest.mark.parametrize("template", [False, True])
@pytest.mark.parametrize("later", [False, True])
def test_value_clips_that_are_not_open_yet_are_read(tmp_path, template, later):
    stage = make_stage()
    mover = UsdGeom.Xform.Define(stage, "/M")
    translate = mover.AddTranslateOp().GetAttr()
    UsdGeom.Cube.Define(stage, "/M/A")
    clips = clips_of(tmp_path, template=template)
    if later:
        extractor = SceneExtractor(stage)
        at(extractor, 12)
        mover.GetPrim().SetMetadata("clips", clips)
    else:
        mover.GetPrim().SetMetadata("clips", clips)
        extractor = SceneExtractor(stage)
    found = [at(extractor, code).instances.local_to_world[0, 3, :3].tolist() for code in (1, 12, 24)]
    np.testing.assert_allclose(found, [translate.Get(code) for code in (1, 12, 24)])
    assert template or found[1] == [1, 0, 0]


CLIP_OF_SIZES = """#usda 1.0
def Xform "M"
{
    def Cube "A"
    {
        double size.timeSamples = {0: 2, 24: 4}
        token visibility.timeSamples = {0: "inherited", 20: "invisible"}
    }
    def Mesh "B"
    {
        point3f[] points.timeSamples = {
            0: [(0, 0, 0), (1, 0, 0), (0, 1, 0)],
            24: [(0, 0, 0), (1, 0, 0), (0, 7, 0)],
        }
    }
}
"""


def test_value_clips_give_values_to_what_no_layer_authors(tmp_path):
    clips = clips_of(tmp_path, template=False)
    (tmp_path / "clip.001.usda").write_text(CLIP_OF_SIZES)
    asset = Usd.Stage.CreateNew(str(tmp_path / "asset.usda"))
    model = UsdGeom.Xform.Define(asset, "/Model").GetPrim()
    UsdGeom.Cube.Define(asset, "/Model/A")
    mesh = UsdGeom.Mesh.Define(asset, "/Model/B")
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    model.SetMetadata("clips", clips)
    asset.Save()
    stage = make_stage()
    for name, offset in (("/M", 0), ("/N", 6)):
        user = stage.DefinePrim(name, "Xform")
        user.GetReferences().AddReference(asset.GetRootLayer().identifier, "/Model", Sdf.LayerOffset(offset))
    extractor = SceneExtractor(stage)
    for code in (0, 18, 12, 24, 6):
        scene = at(extractor, code)
        found = {
            path: float(np.ptp(scene.prototypes[k].points[:, 1]))
            for path, k in zip(scene.instances.paths, scene.instances.prototype)
        }
        expected = {}
        for user in ("/M", "/N"):
            cube = UsdGeom.Cube(stage.GetPrimAtPath(f"{user}/A"))
            if cube.ComputeVisibility(code) != UsdGeom.Tokens.invisible:
                expected[f"{user}/A"] = cube.GetSizeAttr().Get(code)
            points = UsdGeom.Mesh(stage.GetPrimAtPath(f"{user}/B")).GetPointsAttr().Get(code)
            expected[f"{user}/B"] = float(np.ptp(np.array(points)[:, 1]))
        assert found == pytest.approx(expected), code


def test_splines_move_what_is_drawn_and_size_it():
    stage = make_stage()
    ball = UsdGeom.Sphere.Define(stage, "/Ball")
    ball.AddTranslateXOp().GetAttr().SetSpline(spline(0, 2))
    ball.CreateRadiusAttr().SetSpline(spline(1, 3))
    extractor = SceneExtractor(stage)
    for code in (0, 6, 12, 24):
        scene = at(extractor, code)
        assert scene.instances.local_to_world[0, 3, 0] == pytest.approx(ball.GetLocalTransformation(code)[3][0])
        assert scene.prototypes[scene.instances.prototype[0]].points[:, 2].max() == pytest.approx(1 + code / 12)


@pytest.mark.parametrize("beside", [False, True])
def test_a_spline_that_a_script_sets_is_followed(beside):
    """Also below a prim that is new, and of a prim whose poses were written frame by frame before."""
    stage = make_stage()
    ball = UsdGeom.Sphere.Define(stage, "/Ball")
    op = ball.AddTranslateXOp()
    op.Set(5.0)
    extractor = SceneExtractor(stage)
    for number in (6.0, 7.0):
        op.Set(number)
        assert at(extractor, 12).instances.local_to_world[0, 3, 0] == number
    if beside:
        with Sdf.ChangeBlock():
            prim = Sdf.CreatePrimInLayer(stage.GetRootLayer(), "/New")
            prim.specifier, prim.typeName = Sdf.SpecifierDef, "Cube"
            Sdf.AttributeSpec(prim, "xformOp:translateX", Sdf.ValueTypeNames.Double).SetSpline(spline(0, 2))
            order = Sdf.AttributeSpec(prim, "xformOpOrder", Sdf.ValueTypeNames.TokenArray, Sdf.VariabilityUniform)
            order.default = ["xformOp:translateX"]
        assert at(extractor, 12).instances.local_to_world[1, 3, 0] == 1
        assert at(extractor, 24).instances.local_to_world[1, 3, 0] == 2
    else:
        op.GetAttr().SetSpline(spline(0, 2))
        assert at(extractor, 12).instances.local_to_world[0, 3, 0] == 1
        op.GetAttr().SetSpline(spline(0, 4))
        assert at(extractor, 12).instances.local_to_world[0, 3, 0] == 2


def test_splines_inside_instances_are_found(tmp_path):
    asset = Usd.Stage.CreateNew(str(tmp_path / "asset.usda"))
    asset.SetDefaultPrim(UsdGeom.Xform.Define(asset, "/Asset").GetPrim())
    UsdGeom.Cube.Define(asset, "/Asset/A").AddTranslateXOp().GetAttr().SetSpline(spline(0, 2))
    asset.Save()
    stage = make_stage()
    for number in range(2):
        prim = UsdGeom.Xform.Define(stage, f"/o{number}")
        prim.AddTranslateOp().Set(Gf.Vec3d(0, number, 0))
        prim.GetPrim().GetReferences().AddReference(asset.GetRootLayer().identifier)
        prim.GetPrim().SetInstanceable(True)
    extractor = SceneExtractor(stage)
    assert at(extractor, 12).instances.local_to_world[:, 3, :2].tolist() == [[1, 0], [1, 1]]
    assert at(extractor, 24).instances.local_to_world[:, 3, :2].tolist() == [[2, 0], [2, 1]]


def put_box(stage, path):
    box = UsdGeom.Cube.Define(stage, path)
    box.AddTranslateOp().Set(Gf.Vec3d(0))
    box.CreateSizeAttr(2.0)
    box.CreateVisibilityAttr()
    return box


def stage_of_layers():
    """A box in a referenced layer, in one that has an instance, in a sublayer, in a variant and in the root layer.

    Returns it with what edits each: a stage, the layer or edit target, and the path of the box there.
    """
    stage = make_stage()
    places = {"root": (stage, stage.GetRootLayer(), "/Root/Box"), "session": (stage, stage.GetSessionLayer(), "/S/Box")}
    for name in ("referenced", "instanced"):
        asset = Usd.Stage.CreateInMemory()
        asset.SetDefaultPrim(UsdGeom.Xform.Define(asset, "/Asset").GetPrim())
        put_box(asset, "/Asset/Box")
        prim = UsdGeom.Xform.Define(stage, f"/{name}").GetPrim()
        prim.GetReferences().AddReference(asset.GetRootLayer().identifier)
        prim.SetInstanceable(name == "instanced")
        places[name] = asset, asset.GetRootLayer(), "/Asset/Box"
    sublayer = Sdf.Layer.CreateAnonymous("sub.usda")
    stage.GetRootLayer().subLayerPaths.append(sublayer.identifier)
    places["sublayer"] = stage, sublayer, "/Sublayer/Box"
    with Usd.EditContext(stage, sublayer):
        put_box(stage, "/Sublayer/Box")
    for path in ("/Root/Box", "/S/Box"):
        put_box(stage, path)
    variants = UsdGeom.Xform.Define(stage, "/Varied").GetPrim().GetVariantSets().AddVariantSet("kind")
    variants.AddVariant("box")
    variants.SetVariantSelection("box")
    with variants.GetVariantEditContext():
        put_box(stage, "/Varied/Box")
    places["variant"] = stage, variants.GetVariantEditTarget(), "/Varied/Box"
    return stage, places


def drawn_boxes(extractor, code):
    """World (x of the center, size) of each box that is drawn, by its path."""
    scene = at(extractor, code)
    found = {}
    for path, prototype, matrix in zip(
        scene.instances.paths, scene.instances.prototype, scene.instances.local_to_world
    ):
        points = scene.prototypes[prototype].points.astype(float) @ matrix[:3, :3] + matrix[3, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        found[path] = (*np.round((low + high) / 2, 4)[:1].tolist(), round(float(high[0] - low[0]), 4))
    return found


def boxes_of_usd(stage, code):
    found = {}
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if prim.IsA(UsdGeom.Cube) and UsdGeom.Imageable(prim).ComputeVisibility(code) != "invisible":
            x = prim.GetAttribute("xformOp:translate").Get(code)[0]
            found[str(prim.GetPath())] = (round(x, 4), round(prim.GetAttribute("size").Get(code), 4))
    return found


@pytest.mark.parametrize("animated", [False, True])
@pytest.mark.parametrize("place", ["root", "session", "sublayer", "variant", "referenced", "instanced"])
@pytest.mark.parametrize(
    ("name", "first", "last"),
    [
        ("xformOp:translate", Gf.Vec3d(1, 0, 0), Gf.Vec3d(5, 0, 0)),
        ("size", 1.0, 3.0),
        ("visibility", "inherited", "invisible"),
    ],
)
def test_samples_that_a_script_sets_are_followed_in_whichever_layer_they_are(place, animated, name, first, last):
    """They need not be where the stage is edited when it is drawn next, as after `with Usd.EditContext(...)`."""
    stage, places = stage_of_layers()
    if animated:
        other = put_box(stage, "/Other").GetSizeAttr()
        other.Set(1.0, 0)
        other.Set(2.0, 24)
    extractor = SceneExtractor(stage)
    drawn_boxes(extractor, 12)
    edited, target, path = places[place]
    for begin, end in ((first, last), (last, first)):
        with Usd.EditContext(edited, target):
            attribute = edited.GetAttributeAtPath(f"{path}.{name}")
            attribute.Set(begin, 0)
            attribute.Set(end, 24)
        for code in (0, 12, 24, 6):
            assert drawn_boxes(extractor, code) == boxes_of_usd(stage, code)
