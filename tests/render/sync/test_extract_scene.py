"""Which prims become instances, where, with what: composition, visibility, purposes, instancing, broken transforms."""

import math
import warnings

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdPhysics, UsdShade, Vt

from usdsdg.stage.poses.transforms import local_to_world
from usdsdg_render.sync.extract import SceneExtractor
from usdsdg_render.usd.point_instancer import source_path

TRIANGLE = [Gf.Vec3f(0, 0, 0), Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 1, 0)]


def make_stage(up="Z"):
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, up)
    return stage


def add_mesh(stage, path, points=TRIANGLE):
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(points)
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    mesh.CreateSubdivisionSchemeAttr("none")
    return mesh


def add_material(stage, path, color=(1, 0, 0)):
    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, f"{path}/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*color))
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return material


def bind(prim, material):
    UsdShade.MaterialBindingAPI.Apply(prim.GetPrim()).Bind(material)


def extract(stage):
    extractor = SceneExtractor(stage)
    extractor.update()
    return extractor.scene


def base_colors(scene, instance):
    """Base color of each slot that the instance's triangles use."""
    offset = scene.instances.slot_offset[instance]
    prototype = scene.prototypes[scene.instances.prototype[instance]]
    return [
        scene.materials["base_color"][scene.material_slots[offset + k]].tolist()
        for k in np.unique(prototype.triangle_slots)
    ]


def write_asset(folder):
    """A mesh of two materials by subsets, as a file to reference."""
    stage = Usd.Stage.CreateNew(str(folder / "asset.usdc"))
    root = UsdGeom.Xform.Define(stage, "/Asset")
    stage.SetDefaultPrim(root.GetPrim())
    mesh = UsdGeom.Mesh.Define(stage, "/Asset/Mesh")
    mesh.CreatePointsAttr([Gf.Vec3f(x, y, 0) for y in (0, 1) for x in range(9)])
    mesh.CreateFaceVertexCountsAttr([4] * 8)
    mesh.CreateFaceVertexIndicesAttr([k + d for k in range(8) for d in (0, 1, 10, 9)])
    mesh.CreateSubdivisionSchemeAttr("none")
    for name, faces, color in (("a", [0, 1, 2], (1, 0, 0)), ("b", [3, 4, 5, 6, 7], (0, 1, 0))):
        subset = UsdGeom.Subset.CreateGeomSubset(mesh, name, "face", faces, "materialBind")
        bind(subset, add_material(stage, f"/Asset/Looks/{name}", color))
    stage.Save()
    return stage.GetRootLayer().identifier


def test_instances_come_in_stage_order_with_usds_matrices():
    stage = make_stage()
    rng = np.random.default_rng(0)
    for path, kind in (
        ("/World", "Xform"),
        ("/World/Group", "Xform"),
        ("/World/Group/Ball", "Sphere"),
        ("/World/Group/Scope", "Scope"),
        ("/World/Group/Scope/Box", "Cube"),
        ("/World/Cone", "Cone"),
        ("/Outside", "Capsule"),
    ):
        prim = stage.DefinePrim(path, kind)
        if kind != "Scope":
            xform = UsdGeom.Xformable(prim)
            xform.AddTranslateOp().Set(Gf.Vec3d(*rng.normal(size=3)))
            xform.AddRotateXYZOp().Set(Gf.Vec3f(*rng.uniform(-180, 180, 3)))
            xform.AddScaleOp().Set(Gf.Vec3f(*rng.uniform(0.5, 2, 3)))
    UsdGeom.Xformable(stage.GetPrimAtPath("/World/Cone")).SetResetXformStack(True)
    scene = extract(stage)
    assert scene.instances.paths == ("/World/Group/Ball", "/World/Group/Scope/Box", "/World/Cone", "/Outside")
    for path, matrix in zip(scene.instances.paths, scene.instances.local_to_world):
        np.testing.assert_allclose(matrix, np.array(local_to_world(stage.GetPrimAtPath(path))), atol=1e-12)
    cone = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Cone")).GetLocalTransformation()
    np.testing.assert_allclose(scene.instances.local_to_world[2], np.array(cone))


@pytest.mark.parametrize("up", ["Y", "Z"])
def test_up_axis_and_units_do_not_touch_geometry(up):
    stage = make_stage(up)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.Xformable(stage.DefinePrim("/Box", "Cube")).AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    scene = extract(stage)
    assert scene.instances.local_to_world[0, 3].tolist() == [1, 2, 3, 1]
    assert np.abs(scene.prototypes[0].points).max() == 1.0


def test_invisible_and_inactive_prims_are_not_drawn_and_light_nothing():
    stage = make_stage()
    UsdGeom.Imageable(stage.DefinePrim("/Hidden", "Xform")).MakeInvisible()
    stage.DefinePrim("/Hidden/Box", "Cube")
    stage.DefinePrim("/Hidden/Lamp", "SphereLight")
    stage.DefinePrim("/Off/Box", "Cube").GetParent().SetActive(False)
    stage.CreateClassPrim("/Class")
    stage.DefinePrim("/Class/Box", "Cube")
    stage.OverridePrim("/Over/Box")
    stage.DefinePrim("/Shown", "Cube")
    scene = extract(stage)
    assert scene.instances.paths == ("/Shown",)
    assert len(scene.lights) == 0


def test_purposes_are_inherited_and_only_default_and_render_are_drawn():
    stage = make_stage()
    for purpose in ("default", "render", "proxy", "guide"):
        group = UsdGeom.Xform.Define(stage, f"/{purpose}")
        group.CreatePurposeAttr(purpose)
        stage.DefinePrim(f"/{purpose}/Box", "Cube")
    own = UsdGeom.Cube.Define(stage, "/guide/Own")
    own.CreatePurposeAttr("render")
    expected = {p.GetPath().pathString for p in stage.Traverse() if p.IsA(UsdGeom.Gprim)}
    expected = {
        path
        for path in expected
        if UsdGeom.Imageable(stage.GetPrimAtPath(path)).ComputePurpose() in ("default", "render")
    }
    assert set(extract(stage).instances.paths) == expected == {"/default/Box", "/render/Box", "/guide/Own"}


@pytest.mark.parametrize("instanceable", [False, True])
def test_references_share_geometry_and_materials(instanceable, tmp_path):
    stage = make_stage()
    asset = write_asset(tmp_path)
    for k in range(5):
        prim = stage.DefinePrim(f"/World/o{k}", "Xform")
        prim.GetReferences().AddReference(asset)
        prim.SetInstanceable(instanceable)
        if not instanceable:
            UsdPhysics.CollisionAPI.Apply(stage.GetPrimAtPath(f"/World/o{k}/Mesh"))
    scene = extract(stage)
    assert scene.instances.paths == tuple(f"/World/o{k}/Mesh" for k in range(5))
    assert len(scene.prototypes) == 1
    assert len(scene.materials) == 3, "two subsets, and the fallback of faces in none"
    assert base_colors(scene, 3) == [[1, 0, 0], [0, 1, 0]]
    assert scene.prototypes[0].triangle_slots.tolist() == [0] * 6 + [1] * 10


def test_an_override_in_one_reference_stays_its_own(tmp_path):
    stage = make_stage()
    asset = write_asset(tmp_path)
    for k in range(3):
        stage.DefinePrim(f"/o{k}", "Xform").GetReferences().AddReference(asset)
    shader = UsdShade.Shader(stage.GetPrimAtPath("/o1/Looks/a/Surface"))
    shader.GetInput("diffuseColor").Set(Gf.Vec3f(0, 0, 1))
    UsdGeom.Mesh(stage.GetPrimAtPath("/o2/Mesh")).GetPointsAttr().Set(
        [Gf.Vec3f(x, 2 * y, 0) for y in (0, 1) for x in range(9)]
    )
    scene = extract(stage)
    assert [base_colors(scene, k)[0] for k in range(3)] == [[1, 0, 0], [0, 0, 1], [1, 0, 0]]
    heights = [scene.prototypes[k].points[:, 1].max() for k in scene.instances.prototype]
    assert heights == [1, 1, 2]


def test_an_override_beside_the_points_stays_its_own(tmp_path):
    """Sharing goes by what composes a prim, so everything that shapes it must count, not its points alone."""
    stage = make_stage()
    asset = write_asset(tmp_path)
    for k in range(4):
        stage.DefinePrim(f"/o{k}", "Xform").GetReferences().AddReference(asset)
    UsdGeom.Mesh(stage.GetPrimAtPath("/o1/Mesh")).CreateOrientationAttr("leftHanded")
    UsdGeom.Subset(stage.GetPrimAtPath("/o2/Mesh/a")).GetIndicesAttr().Set([0])
    UsdGeom.Mesh(stage.GetPrimAtPath("/o3/Mesh")).CreateHoleIndicesAttr([7])
    prototypes = extract(stage).prototypes
    assert len(prototypes) == 4
    assert [p.normals[0, 0, 2] for p in prototypes] == [1, -1, 1, 1]
    assert [int((p.triangle_slots == 0).sum()) for p in prototypes] == [6, 6, 2, 6]
    assert [len(p.triangles) for p in prototypes] == [16, 16, 16, 14]


def test_an_override_of_a_graph_beside_the_material_stays_its_own(tmp_path):
    asset = Usd.Stage.CreateNew(str(tmp_path / "graph.usda"))
    asset.SetDefaultPrim(UsdGeom.Xform.Define(asset, "/Asset").GetPrim())
    ball = UsdGeom.Sphere.Define(asset, "/Asset/Ball")
    material = add_material(asset, "/Asset/M")
    graph = UsdShade.NodeGraph.Define(asset, "/Asset/Graph")
    color = graph.CreateInput("color", Sdf.ValueTypeNames.Color3f)
    color.Set(Gf.Vec3f(1, 0, 0))
    output = graph.CreateOutput("color", Sdf.ValueTypeNames.Color3f)
    output.ConnectToSource(color)
    UsdShade.Shader(asset.GetPrimAtPath("/Asset/M/Surface")).GetInput("diffuseColor").ConnectToSource(output)
    bind(ball, material)
    asset.Save()
    stage = make_stage()
    for k in range(2):
        stage.DefinePrim(f"/o{k}", "Xform").GetReferences().AddReference(asset.GetRootLayer().identifier)
    stage.GetPrimAtPath("/o1/Graph").GetAttribute("inputs:color").Set(Gf.Vec3f(0, 1, 0))
    scene = extract(stage)
    assert [base_colors(scene, k)[0] for k in range(2)] == [[1, 0, 0], [0, 1, 0]]


def test_equal_meshes_of_different_layers_share_too():
    stage = make_stage()
    for k in range(4):
        add_mesh(stage, f"/m{k}")
    add_mesh(stage, "/other", [Gf.Vec3f(0), Gf.Vec3f(2, 0, 0), Gf.Vec3f(0, 1, 0)])
    scene = extract(stage)
    assert scene.instances.prototype.tolist() == [0, 0, 0, 0, 1]


def add_textured_material(stage, file):
    Image.new("RGB", (2, 2), "red").save(file)
    material = add_material(stage, "/Looks/M")
    texture = UsdShade.Shader.Define(stage, "/Looks/M/Texture")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(str(file))
    surface = UsdShade.Shader.Get(stage, "/Looks/M/Surface")
    surface.GetInput("diffuseColor").ConnectToSource(texture.ConnectableAPI(), "rgb")
    texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)
    return material


def test_meshes_of_one_asset_have_the_texture_coordinates_of_the_prims_above(tmp_path):
    """Constant ones, as of swatches: they are in no spec of the meshes."""
    stage = make_stage()
    stage.CreateClassPrim("/_asset")
    bind(add_mesh(stage, "/_asset/Card").GetPrim(), add_textured_material(stage, tmp_path / "a.png"))
    wanted = [(0.25, 0.5), (0.75, 0.125)]
    for k, uv in enumerate(wanted):
        above = stage.DefinePrim(f"/Card{k}", "Xform")
        above.GetReferences().AddInternalReference("/_asset")
        primvars = UsdGeom.PrimvarsAPI(above)
        primvars.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "constant").Set([Gf.Vec2f(*uv)])
    scene = extract(stage)
    found = [scene.prototypes[k].uvs[0, 0].tolist() for k in scene.instances.prototype]
    assert found == [list(uv) for uv in wanted]


@pytest.mark.parametrize("is_indexed", [False, True])
@pytest.mark.parametrize(
    ("kind", "interpolation"),
    [("BasisCurves", "uniform"), ("BasisCurves", "constant"), ("Points", "vertex"), ("Points", "varying")],
)
def test_curves_and_points_have_one_place_of_a_picture_each(kind, interpolation, is_indexed, tmp_path):
    """As roots of hair on a skin; pxr's flattened primvar says which."""
    stage, count = make_stage(), 3
    prim = stage.DefinePrim("/Fur", kind)
    heights = (0, 1) if kind == "BasisCurves" else (0,)
    prim.GetAttribute("points").Set([Gf.Vec3f(k, y, 0) for k in range(count) for y in heights])
    if kind == "BasisCurves":
        prim.GetAttribute("curveVertexCounts").Set([2] * count)
        prim.GetAttribute("type").Set("linear")
    UsdGeom.PrimvarsAPI(prim).CreatePrimvar("widths", Sdf.ValueTypeNames.FloatArray, "constant").Set([0.1])
    bind(prim, add_textured_material(stage, tmp_path / "a.png"))
    st = UsdGeom.PrimvarsAPI(prim).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, interpolation)
    values = [(0.25, 0.5), (0.75, 0.125), (0.5, 1.0)]
    st.Set([Gf.Vec2f(*uv) for uv in values[: 1 if interpolation == "constant" else None]])
    if is_indexed:
        st.SetIndices([0] if interpolation == "constant" else [2, 0, 0])
    (prototype,) = extract(stage).prototypes
    flattened = np.array(st.ComputeFlattened())
    wanted = flattened[prototype.triangle_faces if len(flattened) > 1 else np.zeros_like(prototype.triangle_faces)]
    np.testing.assert_array_equal(prototype.uvs, np.repeat(wanted[:, None], 3, axis=1))


@pytest.mark.parametrize("interpolation", ["vertex", "varying"])
def test_texture_coordinates_run_along_curves(interpolation, tmp_path):
    """As those of leaves and ropes."""
    stage = make_stage()
    prim = stage.DefinePrim("/Rope", "BasisCurves")
    prim.GetAttribute("points").Set([Gf.Vec3f(0, k, 0) for k in range(3)])
    prim.GetAttribute("curveVertexCounts").Set([3])
    prim.GetAttribute("type").Set("linear")
    UsdGeom.PrimvarsAPI(prim).CreatePrimvar("widths", Sdf.ValueTypeNames.FloatArray, "constant").Set([0.1])
    bind(prim, add_textured_material(stage, tmp_path / "a.png"))
    st = UsdGeom.PrimvarsAPI(prim).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, interpolation)
    st.Set([Gf.Vec2f(0.25, 0), Gf.Vec2f(0.25, 0.75), Gf.Vec2f(0.75, 0.5)])
    (prototype,) = extract(stage).prototypes
    heights = prototype.points[prototype.triangles][..., 1]
    for k, own in enumerate(([0.25, 0.25, 0.75], [0, 0.75, 0.5])):
        np.testing.assert_allclose(prototype.uvs[..., k], np.interp(heights, [0, 1, 2], own), atol=1e-6)


@pytest.mark.parametrize(
    ("kind", "interpolation", "said"),
    [
        ("BasisCurves", "faceVarying", r"for each curve \(uniform\) or vertex"),
        ("BasisCurves", "vertex", r"for each curve \(uniform\) or vertex"),
        ("Points", "uniform", r"for each point \(vertex\)"),
    ],
)
def test_texture_coordinates_that_do_not_fit_curves_and_points_are_named(kind, interpolation, said, tmp_path):
    stage = make_stage()
    prim = stage.DefinePrim("/Fur", kind)
    prim.GetAttribute("points").Set([Gf.Vec3f(0, k, 0) for k in range(3)])
    if kind == "BasisCurves":
        prim.GetAttribute("curveVertexCounts").Set([3])
        prim.GetAttribute("type").Set("linear")
    bind(prim, add_textured_material(stage, tmp_path / "a.png"))
    st = UsdGeom.PrimvarsAPI(prim).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, interpolation)
    st.Set([Gf.Vec2f(0, 0), Gf.Vec2f(0, 1)])
    with pytest.warns(UserWarning, match=f"/Fur: its {interpolation} texture coordinates, 2 values, .*{said}"):
        (prototype,) = extract(stage).prototypes
    assert np.ptp(prototype.uvs) == pytest.approx(1.0)


@pytest.mark.parametrize("is_indexed", [False, True])
@pytest.mark.parametrize(
    ("interpolation", "count", "wanted", "remedy"),
    [
        ("vertex", 7, 3, "Author one value for each element"),
        ("uniform", 3, 1, "Set the interpolation to faceVarying"),
        ("faceVarying", 3, 3, ""),
    ],
)
def test_primvars_with_more_values_than_elements_are_named(interpolation, count, wanted, remedy, is_indexed, tmp_path):
    stage = make_stage()
    mesh = add_mesh(stage, "/Card")
    bind(mesh.GetPrim(), add_textured_material(stage, tmp_path / "a.png"))
    primvars = UsdGeom.PrimvarsAPI(mesh)
    for name, kind, value in (
        ("st", "TexCoord2fArray", Gf.Vec2f(0.5)),
        ("normals", "Normal3fArray", Gf.Vec3f(0, 0, 1)),
    ):
        primvar = primvars.CreatePrimvar(name, getattr(Sdf.ValueTypeNames, kind), interpolation)
        primvar.Set([value] * (1 if is_indexed else count))
        if is_indexed:
            primvar.SetIndices(Vt.IntArray([0] * count))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        extract(stage)
    noun = "indices" if is_indexed else "values"
    expected = [
        f"/Card: the {count} {noun} of its {interpolation} {what} are more than {wanted}; those at the end are "
        f"ignored. {remedy}."
        for what in ("texture coordinates", "normals")
    ]
    assert [str(each.message) for each in caught] == (expected if count > wanted else [])


def test_texture_coordinates_that_no_material_reads_are_not_counted():
    stage = make_stage()
    primvars = UsdGeom.PrimvarsAPI(add_mesh(stage, "/Card"))
    primvars.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex").Set([Gf.Vec2f(0.5)] * 7)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        extract(stage)


def test_shapes_share_by_their_parameters():
    stage = make_stage()
    for k in range(6):
        UsdGeom.Sphere.Define(stage, f"/s{k}").CreateRadiusAttr(1.0 + k % 2)
    assert len(extract(stage).prototypes) == 2


def test_gprims_without_material_show_their_display_color():
    stage = make_stage()
    group = UsdGeom.Xform.Define(stage, "/Group")
    inherited = UsdGeom.PrimvarsAPI(group).CreatePrimvar("displayColor", Sdf.ValueTypeNames.Color3fArray, "constant")
    inherited.Set([Gf.Vec3f(0, 0, 1)])
    UsdGeom.Cube.Define(stage, "/Group/Box")
    ball = UsdGeom.Sphere.Define(stage, "/Ball")
    ball.CreateDisplayColorAttr([Gf.Vec3f(0, 1, 0)])
    ball.CreateDisplayOpacityAttr([0.5])
    UsdGeom.Cone.Define(stage, "/Plain")
    scene = extract(stage)
    assert [base_colors(scene, k)[0] for k in range(3)] == [[0, 0, 1], [0, 1, 0], [0.5, 0.5, 0.5]]
    assert scene.materials["opacity"][scene.material_slots[scene.instances.slot_offset[1]]] == 0.5


def test_varying_display_colors_of_shapes_become_their_mean_and_are_named():
    stage = make_stage()
    ball = UsdGeom.Sphere.Define(stage, "/Ball")
    color = ball.CreateDisplayColorPrimvar("vertex")
    color.Set([Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 1, 0), Gf.Vec3f(0, 0, 1)])
    with pytest.warns(UserWarning, match="/Ball.*displayColor"):
        scene = extract(stage)
    np.testing.assert_allclose(base_colors(scene, 0)[0], 1 / 3, rtol=1e-6)


def test_a_material_may_read_the_gprims_own_color():
    stage = make_stage()
    material = add_material(stage, "/Looks/M")
    reader = UsdShade.Shader.Define(stage, "/Looks/M/Reader")
    reader.CreateIdAttr("UsdPrimvarReader_float3")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("displayColor")
    surface = UsdShade.Shader(stage.GetPrimAtPath("/Looks/M/Surface"))
    surface.GetInput("diffuseColor").ConnectToSource(reader.ConnectableAPI(), "result")
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(0.25)
    for k, color in enumerate([(1, 0, 0), (0, 1, 0), None]):
        ball = UsdGeom.Sphere.Define(stage, f"/b{k}")
        if color is not None:
            ball.CreateDisplayColorAttr([Gf.Vec3f(*color)])
        bind(ball, material)
    scene = extract(stage)
    assert [base_colors(scene, k)[0] for k in range(3)] == [[1, 0, 0], [0, 1, 0], [0.5, 0.5, 0.5]]
    assert (scene.materials["roughness"] == 0.25).all()

    reader.CreateInput("fallback", Sdf.ValueTypeNames.Float3).Set(Gf.Vec3f(0, 0, 1))
    scene = extract(stage)
    assert [base_colors(scene, k)[0] for k in range(3)] == [[1, 0, 0], [0, 1, 0], [0, 0, 1]]


@pytest.mark.parametrize("interpolation", ["constant", "vertex"])
def test_primvars_of_each_point_that_a_material_reads_are_named(interpolation):
    stage = make_stage()
    material = add_material(stage, "/Looks/M")
    reader = UsdShade.Shader.Define(stage, "/Looks/M/Reader")
    reader.CreateIdAttr("UsdPrimvarReader_float3")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("tint")
    reader.CreateInput("fallback", Sdf.ValueTypeNames.Float3).Set(Gf.Vec3f(0, 0, 1))
    surface = UsdShade.Shader(stage.GetPrimAtPath("/Looks/M/Surface"))
    surface.GetInput("diffuseColor").ConnectToSource(reader.ConnectableAPI(), "result")
    instancer = make_instancer(stage, [(0, 0, 0), (5, 0, 0)])
    bind(instancer, material)
    tint = UsdGeom.PrimvarsAPI(instancer).CreatePrimvar("tint", Sdf.ValueTypeNames.Color3fArray, interpolation)
    tint.Set([Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 1, 0)][: 1 if interpolation == "constant" else 2])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene = extract(stage)
    named = [str(each.message) for each in caught]
    assert base_colors(scene, 0) == [[1, 0, 0] if interpolation == "constant" else [0, 0, 1]]
    assert any("/Points: primvars:tint of each point" in each for each in named) == (interpolation == "vertex")


def test_the_uv_set_follows_the_material():
    stage = make_stage()
    material = add_material(stage, "/Looks/M")
    texture = UsdShade.Shader.Define(stage, "/Looks/M/Tex")
    texture.CreateIdAttr("UsdUVTexture")
    reader = UsdShade.Shader.Define(stage, "/Looks/M/Reader")
    reader.CreateIdAttr("UsdPrimvarReader_float2")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("second")
    texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(reader.ConnectableAPI(), "result")
    surface = UsdShade.Shader(stage.GetPrimAtPath("/Looks/M/Surface"))
    surface.GetInput("diffuseColor").ConnectToSource(texture.ConnectableAPI(), "rgb")
    for path in ("/plain", "/bound"):
        api = UsdGeom.PrimvarsAPI(add_mesh(stage, path))
        for name, value in (("st", 0.25), ("second", 0.75)):
            api.CreatePrimvar(name, Sdf.ValueTypeNames.TexCoord2fArray, "constant").Set([Gf.Vec2f(value)])
    bind(stage.GetPrimAtPath("/bound"), material)
    scene = extract(stage)
    assert [scene.prototypes[k].uvs[0, 0, 0] for k in scene.instances.prototype] == [0.25, 0.75]


@pytest.mark.parametrize("scale", [(1, 0, 1), (math.nan, 1, 1), (math.inf, 1, 1)])
def test_unusable_transforms_are_named_and_the_rest_stays(scale):
    stage = make_stage()
    bad = UsdGeom.Xform.Define(stage, "/Bad")
    bad.AddScaleOp().Set(Gf.Vec3f(*scale))
    stage.DefinePrim("/Bad/Box", "Cube")
    stage.DefinePrim("/Good", "Cube")
    with pytest.warns(UserWarning, match="/Bad/Box.*transform"):
        scene = extract(stage)
    assert scene.instances.paths == ("/Good",)


def test_tiny_and_mirrored_scales_are_usable():
    stage = make_stage()
    for k, scale in enumerate([(1e-5, 1e-5, 1e-5), (-1, 1, 1), (1e4, 1e-4, 1)]):
        UsdGeom.Xformable(stage.DefinePrim(f"/b{k}", "Cube")).AddScaleOp().Set(Gf.Vec3f(*scale))
    assert len(extract(stage).instances) == 3


def test_one_broken_mesh_leaves_the_others_alone():
    stage = make_stage()
    UsdGeom.Mesh.Define(stage, "/Empty")
    add_mesh(stage, "/Nan", [Gf.Vec3f(math.nan)] * 3)
    add_mesh(stage, "/Good")
    UsdGeom.BasisCurves.Define(stage, "/Curves")
    with pytest.warns(UserWarning, match="/") as caught:
        scene = extract(stage)
    assert scene.instances.paths == ("/Good",)
    said = "\n".join(str(warning.message) for warning in caught)
    for path in ("/Empty", "/Nan", "/Curves"):
        assert path in said


def test_shadow_casting_follows_omniverses_primvar():
    stage = make_stage()
    for path, value in (("/a", True), ("/b", False), ("/c", None)):
        prim = stage.DefinePrim(path, "Cube")
        if value is not None:
            prim.CreateAttribute("primvars:doNotCastShadows", Sdf.ValueTypeNames.Bool).Set(value)
    assert extract(stage).instances.casts_shadow.tolist() == [0, 1, 1]


def make_instancer(stage, positions):
    instancer = UsdGeom.PointInstancer.Define(stage, "/Points")
    UsdGeom.Xformable(instancer).AddTranslateOp().Set(Gf.Vec3d(0, 0, 10))
    proto = UsdGeom.Xform.Define(stage, "/Points/Protos/Pair")
    proto.AddTranslateOp().Set(Gf.Vec3d(0, 1, 0))
    ball = UsdGeom.Sphere.Define(stage, "/Points/Protos/Pair/Ball")
    ball.AddScaleOp().Set(Gf.Vec3f(2))
    UsdGeom.Cube.Define(stage, "/Points/Protos/Box")
    instancer.CreatePrototypesRel().SetTargets(["/Points/Protos/Pair", "/Points/Protos/Box"])
    instancer.CreatePositionsAttr([Gf.Vec3f(*p) for p in positions])
    instancer.CreateProtoIndicesAttr([k % 2 for k in range(len(positions))])
    return instancer


def test_point_instances_are_placed_as_usd_places_them():
    stage = make_stage()
    instancer = make_instancer(stage, [(k, 0, 0) for k in range(4)])
    turns = [Gf.Rotation(Gf.Vec3d(1, 2, 3), 30 * k).GetQuat() for k in range(4)]
    instancer.CreateOrientationsAttr([Gf.Quath(q.GetReal(), Gf.Vec3h(*q.GetImaginary())) for q in turns])
    instancer.CreateScalesAttr([Gf.Vec3f(1 + k) for k in range(4)])
    scene = extract(stage)
    ball, box = "/Points/Protos/Pair/Ball", "/Points/Protos/Box"
    assert scene.instances.paths == (f"{ball}[0]", f"{box}[1]", f"{ball}[2]", f"{box}[3]")
    assert [source_path(path) for path in scene.instances.paths] == [ball, box, ball, box]
    assert len(scene.prototypes) == 2
    # USD's own matrices hold the prototype root's transform, but not the ball's below it.
    ours = scene.instances.local_to_world
    default = Usd.TimeCode.Default()
    theirs = np.array([np.array(m) for m in instancer.ComputeInstanceTransformsAtTime(default, default)])
    world = np.array(local_to_world(instancer.GetPrim()))
    for k in range(4):
        inner = np.diag([2, 2, 2, 1]) if k % 2 == 0 else np.eye(4)
        np.testing.assert_allclose(ours[k], inner @ theirs[k] @ world, atol=1e-6)


def test_points_of_prototypes_with_several_gprims_come_in_the_order_of_the_points():
    stage = make_stage()
    instancer = make_instancer(stage, [(k, 0, 0) for k in range(6)])
    instancer.GetProtoIndicesAttr().Set([1, 0, 0, 1, 9, 0])  # of the last but one, nothing is drawn
    instancer.CreateInvisibleIdsAttr([2])
    lid = UsdGeom.Cone.Define(stage, "/Points/Protos/Pair/Lid")
    lid.AddTranslateOp().Set(Gf.Vec3d(0, 0, 7))
    with pytest.warns(UserWarning, match="1 entry of protoIndices is outside its 2 prototypes"):
        scene = extract(stage)
    ball, box, lid = ("/Points/Protos/Pair/Ball", "/Points/Protos/Box", "/Points/Protos/Pair/Lid")
    drawn = [(box, 0), (ball, 1), (lid, 1), (box, 3), (ball, 5), (lid, 5)]
    assert scene.instances.paths == tuple(f"{path}[{point}]" for path, point in drawn)
    assert scene.instances.lasting_paths == tuple(f"{path}[/Points:{point}]" for path, point in drawn)

    # A prototype draws the same in the frame above its root, which points move.
    cache, protos = UsdGeom.XformCache(), stage.GetPrimAtPath("/Points/Protos")
    to_world = np.array(cache.GetLocalToWorldTransform(instancer.GetPrim()))
    for (path, point), matrix in zip(drawn, scene.instances.local_to_world):
        moved = np.array(cache.ComputeRelativeTransform(stage.GetPrimAtPath(path), protos)[0])
        moved[3, 0] += point
        np.testing.assert_allclose(matrix, moved @ to_world, atol=1e-6)


def test_point_instances_have_ids_and_can_be_hidden():
    stage = make_stage()
    instancer = make_instancer(stage, [(k, 0, 0) for k in range(4)])
    instancer.CreateIdsAttr([10, 11, 12, 13])
    instancer.CreateInvisibleIdsAttr([12])
    assert extract(stage).instances.paths == (
        "/Points/Protos/Pair/Ball[10]",
        "/Points/Protos/Box[11]",
        "/Points/Protos/Box[13]",
    )


def test_point_instancers_nest():
    stage = make_stage()
    make_instancer(stage, [(0, 0, 0), (5, 0, 0)])
    outer = UsdGeom.PointInstancer.Define(stage, "/Outer")
    outer.CreatePrototypesRel().SetTargets(["/Points"])
    outer.CreatePositionsAttr([Gf.Vec3f(100, 0, 0)])
    outer.CreateProtoIndicesAttr([0])
    scene = extract(stage)
    assert scene.instances.paths[2:] == ("/Points/Protos/Pair/Ball[0][0]", "/Points/Protos/Box[1][0]")
    np.testing.assert_allclose(scene.instances.local_to_world[3, 3], [105, 0, 10, 1])


@pytest.mark.parametrize("purpose", ["guide", "proxy"])
def test_point_instancers_of_other_purposes_draw_nothing_inside_of_others_either(purpose):
    stage = make_stage()
    inner = make_instancer(stage, [(0, 0, 0), (5, 0, 0)])
    for path in ("/Points/Protos/Pair/Ball", "/Points/Protos/Box"):
        UsdGeom.Imageable(stage.GetPrimAtPath(path)).CreatePurposeAttr("render")
    outer = UsdGeom.PointInstancer.Define(stage, "/Outer")
    outer.CreatePrototypesRel().SetTargets(["/Points"])
    outer.CreatePositionsAttr([Gf.Vec3f(100, 0, 0)])
    outer.CreateProtoIndicesAttr([0])
    assert len(extract(stage).instances) == 4
    UsdGeom.Imageable(inner).CreatePurposeAttr(purpose)
    assert not len(extract(stage).instances)


@pytest.mark.parametrize("indices", [[0, 7], [0]])
def test_inconsistent_point_instancers_are_named(indices):
    stage = make_stage()
    make_instancer(stage, [(0, 0, 0), (1, 0, 0)]).GetProtoIndicesAttr().Set(indices)
    with pytest.warns(UserWarning, match="/Points"):
        scene = extract(stage)
    assert len(scene.instances) <= 1


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("positions", [Gf.Vec3f(0)] * 3),
        ("scales", [Gf.Vec3f(1)]),
        ("orientations", [Gf.Quath(1)]),
        ("orientationsf", [Gf.Quatf(1)] * 3),
    ],
)
def test_point_instancers_with_arrays_of_other_lengths_are_named(name, values):
    stage = make_stage()
    instancer = make_instancer(stage, [(0, 0, 0), (1, 0, 0)])
    instancer.GetPrim().GetAttribute(name).Set(values)
    with pytest.warns(
        UserWarning, match=f"/Points: protoIndices has 2 entries, but {name} has {len(values)}; .* not drawn"
    ):
        assert not len(extract(stage).instances)


@pytest.mark.parametrize(
    ("name", "kind", "values", "drawn"),
    [
        ("protoIndices", Sdf.ValueTypeNames.UIntArray, [0, 0], 0),
        ("positions", Sdf.ValueTypeNames.Double3Array, [Gf.Vec3d(0)] * 2, 0),
        ("scales", Sdf.ValueTypeNames.Double3Array, [Gf.Vec3d(3)] * 2, 2),
        ("orientations", Sdf.ValueTypeNames.QuatfArray, [Gf.Quatf(1)] * 2, 2),
        ("invisibleIds", Sdf.ValueTypeNames.IntArray, [0], 2),
    ],
)
def test_arrays_of_point_instancers_that_usd_does_not_read_are_named(name, kind, values, drawn):
    stage = make_stage()
    path = make_instancer(stage, [(0, 0, 0), (1, 0, 0)]).GetPath()
    spec = stage.GetRootLayer().GetPrimAtPath(path)
    if name in spec.properties:
        spec.RemoveProperty(spec.properties[name])
    Sdf.AttributeSpec(spec, name, kind).default = values
    with pytest.warns(UserWarning, match=f"/Points: {name} has values of the type .* ignored. Author them as "):
        assert len(extract(stage).instances) == drawn


def test_point_instancers_that_draw_each_other_end():
    stage = make_stage()
    first = make_instancer(stage, [(0, 0, 0), (1, 0, 0)])
    second = UsdGeom.PointInstancer.Define(stage, "/Other")
    second.CreatePositionsAttr([Gf.Vec3f(0)])
    second.CreateProtoIndicesAttr([0])
    second.CreatePrototypesRel().SetTargets(["/Points"])
    first.CreatePrototypesRel().SetTargets(["/Other", "/Points/Protos/Box"])
    with pytest.warns(UserWarning, match="/Points is among its prototypes and draws it in turn"):
        paths = extract(stage).instances.paths
    assert "/Points/Protos/Box[1]" in paths


@pytest.mark.parametrize(
    ("add", "named"),
    [
        (lambda stage, instancer: instancer.CreatePrototypesRel().SetTargets(["/Gone", "/Points/Protos/Box"]), "/Gone"),
        (lambda stage, _: UsdLux.SphereLight.Define(stage, "/Points/Protos/Pair/Lamp"), "Pair/Lamp: lights in the"),
        (lambda stage, _: stage.DefinePrim("/Points/Protos/Pair/Patch", "Volume"), "Pair/Patch: Volume is not"),
        (
            lambda stage, _: stage.DefinePrim("/Points/Protos/Pair/Hair", "GenerativeProcedural"),
            "Pair/Hair: Generative",
        ),
        (
            lambda _, instancer: UsdGeom.PrimvarsAPI(instancer).CreatePrimvar(
                "displayColor", Sdf.ValueTypeNames.Color3fArray, "vertex"
            ),
            "/Points: primvars:displayColor of each point",
        ),
    ],
)
def test_what_point_instancers_cannot_draw_is_named(add, named):
    stage = make_stage()
    instancer = make_instancer(stage, [(0, 0, 0), (1, 0, 0)])
    add(stage, instancer)
    with pytest.warns(UserWarning, match=named):
        assert "/Points/Protos/Box[1]" in extract(stage).instances.paths


def test_samples_count_where_there_is_no_default():
    stage = make_stage()
    stage.SetStartTimeCode(1)
    stage.SetEndTimeCode(10)
    op = UsdGeom.Xformable(stage.DefinePrim("/Box", "Cube")).AddTranslateOp()
    op.Set(Gf.Vec3d(5, 0, 0), 1)
    op.Set(Gf.Vec3d(50, 0, 0), 10)
    fixed = UsdGeom.Xformable(stage.DefinePrim("/Fixed", "Cube")).AddTranslateOp()
    fixed.Set(Gf.Vec3d(7, 0, 0))
    assert extract(stage).instances.local_to_world[:, 3, 0].tolist() == [5, 7]
    later = SceneExtractor(stage, time=Usd.TimeCode(10))
    later.update()
    assert later.scene.instances.local_to_world[:, 3, 0].tolist() == [50, 7]


def test_progress_reaches_the_total():
    stage = make_stage()
    for k in range(3):
        stage.DefinePrim(f"/b{k}", "Cube")
    calls = []
    SceneExtractor(stage, lambda *step: calls.append(step)).update()
    assert calls[-1] == ("geometry", 3, 3)


@pytest.mark.parametrize("mode", ["noMaterialResponse", "independent", "materialGlowTintsLight"])
def test_mesh_lights_emit(mode):
    stage = make_stage()
    mesh = add_mesh(stage, "/Panel")
    material = add_material(stage, "/Looks/M")
    surface = UsdShade.Shader(stage.GetPrimAtPath("/Looks/M/Surface"))
    surface.CreateInput("emissiveColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(1, 0.5, 0))
    bind(mesh, material)
    light = UsdLux.MeshLightAPI.Apply(mesh.GetPrim())
    api = UsdLux.LightAPI(light)
    api.CreateIntensityAttr(8.0)
    api.CreateMaterialSyncModeAttr(mode)
    scene = extract(stage)
    row = scene.materials[scene.material_slots[scene.instances.slot_offset[0]]]
    expected = {
        "noMaterialResponse": ([0, 0, 0], [8, 8, 8]),
        "independent": ([1, 0, 0], [8, 8, 8]),
        "materialGlowTintsLight": ([1, 0, 0], [8, 4, 0]),
    }[mode]
    assert (row["base_color"].tolist(), row["emission"].tolist()) == expected
    assert len(scene.lights) == 0


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("specular", 0.5),
        ("shaping:cone:angle", 30.0),
        ("shaping:ies:file", Sdf.AssetPath("lamp.ies")),
        ("shadow:enable", False),
        ("shadow:color", Gf.Vec3f(1, 0, 0)),
    ],
)
def test_what_a_mesh_light_does_not_have_is_named(name, value):
    stage = make_stage()
    prim = add_mesh(stage, "/Lamp").GetPrim()
    for schema in (UsdLux.MeshLightAPI, UsdLux.ShapingAPI, UsdLux.ShadowAPI):
        schema.Apply(prim)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        extract(stage)
    prim.GetAttribute(f"inputs:{name}").Set(value)
    with pytest.warns(UserWarning, match=f"/Lamp: a mesh light shines to all sides.*; inputs:{name} have no effect"):
        extract(stage)


def test_links_of_a_mesh_light_are_named():
    stage = make_stage()
    light = UsdLux.LightAPI(UsdLux.MeshLightAPI.Apply(add_mesh(stage, "/Lamp").GetPrim()))
    light.GetLightLinkCollectionAPI().ExcludePath("/Other")
    with pytest.warns(UserWarning, match="/Lamp: a mesh light .*; its light and shadow links have no effect"):
        extract(stage)


def test_an_empty_stage_gives_an_empty_scene():
    scene = extract(make_stage())
    assert len(scene.instances) == len(scene.prototypes) == len(scene.materials) == len(scene.lights) == 0
    assert scene.dome is None


def test_lights_and_domes_are_found():
    stage = make_stage()
    for kind in ("SphereLight", "DistantLight", "RectLight", "DiskLight", "CylinderLight"):
        stage.DefinePrim(f"/{kind}", kind)
    UsdLux.DomeLight.Define(stage, "/Sky").CreateIntensityAttr(5)
    stage.DefinePrim("/Portal", "PortalLight")
    with pytest.warns(UserWarning, match="/Portal"):
        scene = extract(stage)
    assert scene.lights["kind"].tolist() == [0, 1, 2, 3, 4]
    assert scene.dome is not None


@pytest.mark.parametrize(
    ("family", "element", "faces", "named"),
    [
        ("other", "face", [0], "its familyName is 'other' and its elementType face"),
        ("materialBind", "point", [0], "its familyName is 'materialBind' and its elementType point"),
        ("materialBind", "face", [0, 0], None),
    ],
)
def test_subsets_whose_material_does_not_count_are_named(family, element, faces, named):
    stage = make_stage()
    subset = UsdGeom.Subset.CreateGeomSubset(add_mesh(stage, "/Mesh"), "part", element, faces, family)
    bind(subset, add_material(stage, "/Looks/Red"))
    if named is None:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert base_colors(extract(stage), 0) == [[1, 0, 0]]
        return
    with pytest.warns(UserWarning, match=f"/Mesh/part: its material does not count, since {named}"):
        assert base_colors(extract(stage), 0) == [[0.5, 0.5, 0.5]]


@pytest.mark.parametrize("kind", ["Xform", "BasisCurves"])
def test_subsets_whose_parent_is_no_mesh_are_named(kind):
    stage = make_stage()
    add_mesh(stage, "/Mesh")
    stage.DefinePrim("/Mesh/Other", kind)
    subset = UsdGeom.Subset.Define(stage, "/Mesh/Other/part")
    subset.CreateFamilyNameAttr("materialBind")
    subset.CreateIndicesAttr([0])
    bind(subset, add_material(stage, "/Looks/Red"))
    with pytest.warns(UserWarning, match="/Mesh/Other/part: its material does not count, .* /Mesh/Other is none"):
        assert base_colors(extract(stage), 0) == [[0.5, 0.5, 0.5]]


def test_subsets_that_overlap_are_named():
    stage = make_stage()
    mesh = add_mesh(stage, "/Mesh")
    for name, color in (("a", (1, 0, 0)), ("b", (0, 1, 0))):
        subset = UsdGeom.Subset.CreateGeomSubset(mesh, name, "face", [0], "materialBind")
        bind(subset, add_material(stage, f"/Looks/{name}", color))
    with pytest.warns(UserWarning, match="/Mesh: material subset 1 names 1 face of the subsets before it; it wins"):
        assert base_colors(extract(stage), 0) == [[0, 1, 0]]


@pytest.mark.parametrize("size", [1e-12, 1e12])
def test_sizes_that_32_bits_cannot_shade_are_named(size):
    stage = make_stage()
    add_mesh(stage, "/Mesh", [size * point for point in TRIANGLE])
    UsdGeom.Cube.Define(stage, "/Box").CreateSizeAttr(size)
    with pytest.warns(UserWarning, match="32-bit numbers show") as told:
        extract(stage)
    named = sorted(str(each.message).split(" units")[0] for each in told)
    assert named == [f"{path}: it is {size:.1g}" for path in ("/Box", "/Mesh")]


@pytest.mark.parametrize("scale", [1e-12, 1e20])
def test_transforms_that_32_bits_lose_are_named(scale):
    stage = make_stage()
    UsdGeom.Cube.Define(stage, "/Box").AddTransformOp().Set(Gf.Matrix4d().SetScale(scale))
    with pytest.warns(UserWarning, match="/Box: its transform is .* so far out of proportion"):
        assert not len(extract(stage).instances)


@pytest.mark.parametrize(("value", "drawn"), [(1e30, 1e3), (math.nan, 0.5)])
def test_display_colors_that_are_none_are_named(value, drawn):
    stage = make_stage()
    add_mesh(stage, "/Mesh").CreateDisplayColorAttr([Gf.Vec3f(value)])
    with pytest.warns(UserWarning, match="/Mesh.primvars:displayColor"):
        assert base_colors(extract(stage), 0) == [[drawn] * 3]


def test_textures_on_a_mesh_without_coordinates_are_named(tmp_path):
    Image.new("RGB", (2, 2)).save(tmp_path / "a.png")
    stage = make_stage()
    material = add_material(stage, "/Looks/M")
    texture = UsdShade.Shader.Define(stage, "/Looks/M/Tex")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(str(tmp_path / "a.png"))
    surface = UsdShade.Shader(stage.GetPrimAtPath("/Looks/M/Surface"))
    surface.GetInput("diffuseColor").ConnectToSource(texture.ConnectableAPI(), "rgb")
    bind(add_mesh(stage, "/Mesh"), material)
    bind(UsdGeom.Sphere.Define(stage, "/Ball"), material)
    with pytest.warns(UserWarning, match="they show one texel") as told:
        extract(stage)
    assert [str(each.message).split(":")[0] for each in told] == ["/Mesh"]
