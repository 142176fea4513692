"""Any value of any attribute leaves a sound scene, and everything else in place."""

import math

import pytest
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdLux, UsdShade

from tests.render.sync.scene_checks import assert_sound
from tests.sampled_cases import sampled
from usdsdg_render.sync.extract import SceneExtractor

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")

T = Sdf.ValueTypeNames
NUMBERS = (math.nan, -1.0, 1e38)
INTEGERS = (-1, 2**31 - 1, 7)
WORDS = ("bogus", "invisible", "leftHanded")


def wrong_values(attribute):
    """Bad values of the attribute's type; none for types that this test does not vary."""
    name = str(attribute.GetTypeName())
    kind = attribute.GetTypeName().scalarType.type
    vectors = {
        T.Float3.type: Gf.Vec3f,
        T.Double3.type: Gf.Vec3d,
        T.Float2.type: Gf.Vec2f,
        T.Float4.type: Gf.Vec4f,
        T.Double2.type: Gf.Vec2d,
        T.Int3.type: lambda x: Gf.Vec3i(0, 1, int(min(max(x, -1.0), 7.0)) if x == x else 2),
        T.Int4.type: lambda x: Gf.Vec4i(0, 1, 2, int(min(max(x, -1.0), 7.0)) if x == x else 2),
        T.Quatf.type: lambda x: Gf.Quatf(x, x, x, x),
        T.Quath.type: lambda x: Gf.Quath(min(x, 9.0), 0, 0, 0),
    }
    if kind in vectors:
        values = [vectors[kind](number) for number in NUMBERS]
    elif kind in (T.Float.type, T.Double.type):
        values = list(NUMBERS)
    elif kind in (T.Int.type,):
        values = list(INTEGERS)
    elif kind in (T.Token.type, T.String.type):
        values = list(WORDS)
    elif kind == T.Asset.type:
        values = [Sdf.AssetPath(path) for path in ("<UDIM>.png", "/", "a.usdz[b.png]")]
    else:
        return []
    if name.endswith("[]"):
        return [[], *([value] * length for value, length in zip(values, (1, 24, 100)))]
    return values


def add_shader(stage, path, inputs):
    shader = UsdShade.Shader.Define(stage, path)
    for name, kind in inputs.items():
        shader.CreateInput(name, kind)
    return shader


@pytest.fixture
def stage():
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.Cube.Define(stage, "/Witness")
    mesh = UsdGeom.Mesh.Define(stage, "/World/Mesh")
    mesh.CreatePointsAttr([Gf.Vec3f(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)])
    mesh.CreateFaceVertexCountsAttr([4] * 6)
    mesh.CreateFaceVertexIndicesAttr([0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6, 4, 5, 7, 6, 2, 3, 1, 0])
    mesh.CreateNormalsAttr([Gf.Vec3f(0, 0, 1)] * 24)
    mesh.SetNormalsInterpolation("faceVarying")
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", T.TexCoord2fArray, "vertex")
    st.Set([Gf.Vec2f(0)] * 8)
    st.SetIndices(list(range(8)))
    UsdGeom.Subset.CreateGeomSubset(mesh, "part", "face", [0, 1], "materialBind")
    for kind in ("Sphere", "Cube", "Cone", "Capsule", "Cylinder", "Plane", "Capsule_1", "Cylinder_1"):
        UsdGeom.Gprim(stage.DefinePrim(f"/World/{kind}", kind)).CreateDisplayColorAttr([Gf.Vec3f(1)])
    patch = UsdGeom.NurbsPatch.Define(stage, "/World/NurbsPatch")
    patch.CreatePointsAttr([Gf.Vec3f(x, y, 0) for y in (0, 1) for x in (0, 1)])
    for way in "uv":
        for name, value in (("VertexCount", 2), ("Order", 2), ("Knots", [0, 0, 1, 1]), ("Range", Gf.Vec2d(0, 1))):
            patch.GetPrim().GetAttribute(way + name).Set(value)
    patch.CreatePointWeightsAttr([1.0] * 4)
    tets = UsdGeom.TetMesh.Define(stage, "/World/TetMesh")
    tets.CreatePointsAttr([Gf.Vec3f(0), Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 1, 0), Gf.Vec3f(0, 0, 1)])
    tets.CreateTetVertexIndicesAttr([Gf.Vec4i(0, 1, 2, 3)])
    tets.CreateSurfaceFaceVertexIndicesAttr(UsdGeom.TetMesh.ComputeSurfaceFaces(tets, Usd.TimeCode.Default()))
    for kind in ("SphereLight", "RectLight", "DiskLight", "CylinderLight", "DistantLight", "DomeLight", "DomeLight_1"):
        UsdLux.ShapingAPI.Apply(stage.DefinePrim(f"/Lights/{kind}", kind))
    for path in ("/World", "/World/Mesh", "/Lights/SphereLight", "/Lights/DomeLight"):
        xform = UsdGeom.Xformable(stage.DefinePrim(path, stage.GetPrimAtPath(path).GetTypeName() or "Xform"))
        xform.AddTranslateOp().Set(Gf.Vec3d(1))
        xform.AddOrientOp().Set(Gf.Quatf(1))
        xform.AddScaleOp().Set(Gf.Vec3f(1))
    instancer = UsdGeom.PointInstancer.Define(stage, "/Points")
    UsdGeom.Cube.Define(stage, "/Points/Box")
    instancer.CreatePrototypesRel().SetTargets(["/Points/Box"])
    instancer.CreatePositionsAttr([Gf.Vec3f(1)] * 3)
    instancer.CreateProtoIndicesAttr([0] * 3)
    for create in (instancer.CreateOrientationsAttr, instancer.CreateScalesAttr, instancer.CreateIdsAttr):
        create()
    preview = UsdShade.Material.Define(stage, "/Looks/Preview")
    colors = dict.fromkeys(("diffuseColor", "emissiveColor", "specularColor"), T.Color3f)
    numbers = dict.fromkeys(("roughness", "metallic", "opacity", "ior", "clearcoat"), T.Float)
    surface = add_shader(stage, "/Looks/Preview/S", {**colors, **numbers, "useSpecularWorkflow": T.Int})
    surface.CreateIdAttr("UsdPreviewSurface")
    vectors = dict.fromkeys(("scale", "bias", "fallback"), T.Float4)
    texture = add_shader(stage, "/Looks/Preview/T", {"file": T.Asset, "wrapS": T.Token, **vectors})
    texture.CreateIdAttr("UsdUVTexture")
    surface.CreateInput("normal", T.Normal3f).ConnectToSource(texture.ConnectableAPI(), "rgb")
    surface.CreateInput("occlusion", T.Float).ConnectToSource(texture.ConnectableAPI(), "r")
    preview.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(preview)
    omni = UsdShade.Material.Define(stage, "/Looks/Omni")
    names = ("albedo_add", "reflection_roughness_constant", "reflection_roughness_texture_influence", "bump_factor")
    files = dict.fromkeys(("diffuse_texture", "reflectionroughness_texture"), T.Asset)
    shader = add_shader(stage, "/Looks/Omni/S", {**dict.fromkeys(names, T.Float), **files, "texture_scale": T.Float2})
    shader.SetSourceAsset("OmniPBR.mdl", "mdl")
    shader.SetSourceAssetSubIdentifier("OmniPBR", "mdl")
    omni.CreateSurfaceOutput("mdl").ConnectToSource(shader.ConnectableAPI(), "out")
    UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath("/World/Sphere")).Bind(omni)
    return stage


def test_no_value_of_any_attribute_breaks_the_scene(stage):
    extractor = SceneExtractor(stage)
    extractor.update()
    everything = set(extractor.scene.instances.paths)
    assert len(everything) == 1 + 11 + 3
    assert len(extractor.scene.lights) == 5
    tried, checked = 0, {}
    for prim in stage.Traverse():
        for attribute in prim.GetAttributes():
            authored = attribute.Get() if attribute.HasAuthoredValue() else None
            for value in wrong_values(attribute):
                try:
                    attribute.Set(value)
                except Tf.ErrorException:  # USD itself refuses it
                    continue
                extractor.update()
                assert_sound(extractor.scene, checked)
                assert "/Witness" in extractor.scene.instances.paths or prim.GetPath() == "/Witness"
                tried += 1
            if authored is None:
                attribute.Clear()
            else:
                attribute.Set(authored)
    extractor.update()
    assert tried > 500
    assert set(extractor.scene.instances.paths) == everything, "all are back once the values are"
    assert len(extractor.scene.lights) == 5


@pytest.mark.parametrize(
    ("kind", "value"),
    sampled(
        [
            (T.String, "x"),
            (T.Matrix4d, Gf.Matrix4d(1)),
            (T.Color3f, Gf.Vec3f(1)),
            (T.StringArray, ["a", "b"]),
            (T.Asset, Sdf.AssetPath("a.png")),
        ],
        2,
    ),
    ids=str,
)
def test_no_type_of_any_attribute_breaks_the_scene(stage, kind, value):
    extractor = SceneExtractor(stage)
    extractor.update()
    everything = set(extractor.scene.instances.paths)
    session, tried, checked = stage.GetSessionLayer(), 0, {}
    for prim in stage.Traverse():
        for attribute in prim.GetAttributes():
            if attribute.GetTypeName() == kind:
                continue
            # A stage refuses a value of another type; a layer does not.
            over = Sdf.CreatePrimInLayer(session, prim.GetPath())
            spec = Sdf.AttributeSpec(over, attribute.GetName(), kind)
            spec.default = value
            extractor.update()
            assert_sound(extractor.scene, checked)
            assert "/Witness" in extractor.scene.instances.paths or prim.GetPath() == "/Witness"
            over.RemoveProperty(spec)
            tried += 1
    extractor.update()
    assert tried > 300
    assert set(extractor.scene.instances.paths) == everything, "all are back once the values are"
    assert len(extractor.scene.lights) == 5
