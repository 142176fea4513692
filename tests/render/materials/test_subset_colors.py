"""displayColor that varies over a mesh of which some faces have materials of their own."""

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf, UsdGeom, UsdShade

from tests.render.test_stage_to_image import QUARTERS, labels, make_stage, view_of
from usdsdg.errors import forget_warnings
from usdsdg_render.renderer import WarpRenderer

T = Sdf.ValueTypeNames
DISTANCE = 5.0
PLAIN = (0.1, 0.2, 0.3)


def add_strip(stage):
    """Four squares side by side before the camera, 1.25 wide; displayColor varies with x and z."""
    mesh = UsdGeom.Mesh.Define(stage, "/Strip")
    places = [(-2.5 + 1.25 * k, z) for z in (-1.25, 1.25) for k in range(5)]
    mesh.CreatePointsAttr([Gf.Vec3f(x, DISTANCE, z) for x, z in places])
    mesh.CreateFaceVertexCountsAttr([4] * 4)
    mesh.CreateFaceVertexIndicesAttr([k + step for k in range(4) for step in (0, 1, 6, 5)])
    mesh.CreateSubdivisionSchemeAttr("none")
    mesh.CreateDisplayColorPrimvar("vertex").Set([Gf.Vec3f(*color_at(x, z)) for x, z in places])
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", T.TexCoord2fArray, "vertex")
    st.Set([Gf.Vec2f(x / 1.25, z / 2.5 + 0.5) for x, z in places])
    return mesh


def color_at(x, z):
    return 0.5 + 0.15 * x, 0.5 + 0.25 * z, 0.25


def add_material(stage, name, **inputs):
    """A UsdPreviewSurface; `file` is the texture of its color, `reads` whether that is the displayColor."""
    material = UsdShade.Material.Define(stage, f"/Looks/{name}")
    surface = UsdShade.Shader.Define(stage, f"/Looks/{name}/Surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    color = surface.CreateInput("diffuseColor", T.Color3f)
    if "file" in inputs:
        source = UsdShade.Shader.Define(stage, f"/Looks/{name}/Picture")
        source.CreateIdAttr("UsdUVTexture")
        source.CreateInput("file", T.Asset).Set(inputs["file"])
        color.ConnectToSource(source.ConnectableAPI(), "rgb")
    elif "reads" in inputs:
        source = UsdShade.Shader.Define(stage, f"/Looks/{name}/Reader")
        source.CreateIdAttr("UsdPrimvarReader_float3")
        source.CreateInput("varname", T.String).Set("displayColor")
        color.ConnectToSource(source.ConnectableAPI(), "result")
    else:
        color.Set(Gf.Vec3f(*inputs["color"]))
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    return material


def add_subset(mesh, face, material):
    subset = UsdGeom.Subset.CreateGeomSubset(mesh, f"face{face}", "face", [face], "materialBind")
    UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)


def seen_faces(stage):
    """(face, albedo, x, z) of the pixels of the strip."""
    seen = labels(stage, "albedo", "prim", "position")
    hit = seen["prim"] >= 0
    assert hit.sum() == 32
    at = seen["position"][hit]
    return seen["prim"][hit], seen["albedo"][hit], at[:, 0], at[:, 2]


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0)])
def test_each_subset_has_its_own_look(tmp_path, recwarn, order):
    """A constant, a texture, a reader of displayColor, and, on the face of no subset, displayColor itself."""
    forget_warnings()
    Image.fromarray(QUARTERS).resize((256, 256), Image.Resampling.NEAREST).save(tmp_path / "quarters.png")
    stage = make_stage()
    mesh = add_strip(stage)
    materials = [
        add_material(stage, "Plain", color=PLAIN),
        add_material(stage, "Picture", file=str(tmp_path / "quarters.png")),
        add_material(stage, "Reader", reads=True),
    ]
    for face in order:
        add_subset(mesh, face, materials[face])
    faces, albedo, x, z = seen_faces(stage)
    assert set(faces.tolist()) == {0, 1, 2, 3}
    expected = np.stack(np.broadcast_arrays(*color_at(x, z)), axis=-1)
    u, v = (x / 1.25) % 1.0, z / 2.5 + 0.5
    quarter = QUARTERS[(v < 0.5).astype(int), (u >= 0.5).astype(int)] / 255.0
    expected[faces == 0] = PLAIN
    expected[faces == 1] = quarter[faces == 1]
    np.testing.assert_allclose(albedo, expected, atol=0.01)
    assert not recwarn.list


def test_a_color_that_no_face_shows_is_not_warned_of(tmp_path, recwarn):
    forget_warnings()
    stage = make_stage()
    mesh = add_strip(stage)
    plain = add_material(stage, "Plain", color=PLAIN)
    for face in range(4):
        add_subset(mesh, face, plain)
    _, albedo, _, _ = seen_faces(stage)
    np.testing.assert_allclose(albedo, np.broadcast_to(PLAIN, albedo.shape), atol=1e-6)
    assert not recwarn.list


def test_edits_of_what_is_shown_are_followed(tmp_path):
    """Each state looks as a new renderer draws it."""
    Image.fromarray(QUARTERS).save(tmp_path / "quarters.png")
    stage = make_stage()
    mesh = add_strip(stage)
    plain = add_material(stage, "Plain", color=PLAIN)
    picture = add_material(stage, "Picture", file=str(tmp_path / "quarters.png"))
    add_subset(mesh, 0, plain)
    add_subset(mesh, 1, picture)
    renderer = WarpRenderer(stage, device="cpu")
    rest = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim())
    first = UsdShade.MaterialBindingAPI(UsdGeom.Subset.Get(stage, "/Strip/face0").GetPrim())
    colors = mesh.GetDisplayColorPrimvar()
    edits = [
        lambda: None,
        lambda: colors.Set(list(reversed(colors.Get()))),
        lambda: rest.Bind(plain),
        lambda: first.UnbindAllBindings(),
        lambda: rest.UnbindAllBindings(),
        lambda: mesh.GetPointsAttr().Set([point + Gf.Vec3f(0.5, 0, 0) for point in mesh.GetPointsAttr().Get()]),
        lambda: colors.Set([Gf.Vec3f(0.5)] * 10),
        lambda: first.Bind(picture),
    ]
    for edit in edits:
        edit()
        renderer.sync()
        kept = renderer.labels(view_of(stage), ("albedo",))["albedo"]
        np.testing.assert_array_equal(kept, labels(stage, "albedo")["albedo"])
