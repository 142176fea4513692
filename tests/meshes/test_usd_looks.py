"""Materials of USD files that are converted: drawn, they look as those of the file itself do."""

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Usd, UsdGeom, UsdShade

from tests.render.materials.test_subset_colors import T
from tests.render.test_stage_to_image import labels, make_stage
from usdsdg.image_files.png import encode_png
from usdsdg.meshes.conversion import Options, convert

INPUTS = {
    "diffuseColor": (T.Color3f, "rgb"),
    "emissiveColor": (T.Color3f, "rgb"),
    "roughness": (T.Float, "rgba"),
    "metallic": (T.Float, "rgba"),
    "opacity": (T.Float, "rgba"),
}
SHOWN = ("albedo", "diffuse", "specular", "roughness", "emission")


def save(draw, file):
    """Save a picture of any number of channels and of 8 or 16 bits."""
    kind = np.uint8 if draw.random() < 0.6 else np.uint16
    channels = int(draw.integers(1, 5))
    values = draw.integers(0, np.iinfo(kind).max + 1, (3, 4, channels)).astype(kind)
    if channels == 2:  # gray and alpha, of 8 bits
        Image.fromarray((values // (257 if kind == np.uint16 else 1)).astype(np.uint8), "LA").save(file)
    else:
        file.write_bytes(encode_png(values[..., 0] if channels == 1 else values))


def add_picture(stage, draw, tmp_path, name, shared):
    """A UsdUVTexture with a random file, color space, wrap modes and scale."""
    texture = UsdShade.Shader.Define(stage, f"/Wall/Look/{name}")
    texture.CreateIdAttr("UsdUVTexture")
    file = shared if draw.random() < 0.3 else tmp_path / f"{name}.png"
    if file is not shared:
        save(draw, file)
    texture.CreateInput("file", T.Asset).Set(str(file))
    if draw.random() < 0.8:
        texture.CreateInput("sourceColorSpace", T.Token).Set(str(draw.choice(["auto", "sRGB", "raw"])))
    for axis in ("wrapS", "wrapT"):
        texture.CreateInput(axis, T.Token).Set(str(draw.choice(["repeat", "clamp", "mirror", "black"])))
    if draw.random() < 0.5:
        texture.CreateInput("scale", T.Float4).Set(Gf.Vec4f(*draw.uniform(0.1, 1.0, 4).tolist()))
    return texture


def wall(draw, tmp_path):
    """A square of 4 m at the origin, with some inputs of its material constant and some of pictures."""
    stage = Usd.Stage.CreateNew(str(tmp_path / "wall.usda"))
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Wall").GetPrim())
    mesh = UsdGeom.Mesh.Define(stage, "/Wall/Mesh")
    corners = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)]
    mesh.CreatePointsAttr([Gf.Vec3f(x, 0.0, z) for x, z in corners])
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateSubdivisionSchemeAttr("none")
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", T.TexCoord2fArray, "vertex")
    st.Set([Gf.Vec2f(x * 0.8, z * 0.7) for x, z in corners])
    material = UsdShade.Material.Define(stage, "/Wall/Look")
    surface = UsdShade.Shader.Define(stage, "/Wall/Look/Surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    shared = tmp_path / "shared.png"
    save(draw, shared)
    for name, (kind, outputs) in INPUTS.items():
        chance = draw.random()
        if chance < 0.2:
            continue
        made = surface.CreateInput(name, kind)
        if chance < 0.4:
            value = draw.uniform(0.1, 1.0, 3).tolist()
            made.Set(Gf.Vec3f(*value) if kind == T.Color3f else value[0])
        else:
            texture = add_picture(stage, draw, tmp_path, name, shared)
            output = "rgb" if kind == T.Color3f else str(draw.choice(list(outputs)))
            made.ConnectToSource(texture.ConnectableAPI(), output)
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
    stage.Save()
    return tmp_path / "wall.usda"


def seen(file):
    stage = make_stage()
    prim = UsdGeom.Xform.Define(stage, "/Shown")
    prim.AddTranslateOp().Set(Gf.Vec3d(0.0, 2.1, 0.0))
    prim.GetPrim().GetReferences().AddReference(str(file))
    return labels(stage, *SHOWN, "distance_to_camera")


@pytest.mark.parametrize("seed", range(40))
def test_a_converted_material_looks_as_it_did(seed, tmp_path):
    file = wall(np.random.default_rng(seed), tmp_path)
    report, _ = convert(file, tmp_path / "out" / "wall.usda", Options(up_axis="Z"))
    assert report.notes == []
    before, after = seen(file), seen(tmp_path / "out" / "wall.usda")
    there, hit = np.isfinite(before["distance_to_camera"]), np.isfinite(after["distance_to_camera"])
    assert (there != hit).sum() <= 2  # an opacity of 8 bits may be on the other side of what is seen as a hole
    hit &= there
    for name in SHOWN:
        # Colors and numbers are kept in 8 bits, and sums of two of them are compared.
        np.testing.assert_allclose(after[name][hit], before[name][hit], atol=0.011, err_msg=name)


def test_a_converted_material_keeps_its_coat_its_ior_and_what_its_opacity_is(tmp_path):
    file, numbers = (
        wall(np.random.default_rng(0), tmp_path),
        {"clearcoat": 0.75, "clearcoatRoughness": 0.25, "ior": 2.0},
    )
    stage = Usd.Stage.Open(str(file))
    surface = UsdShade.Shader.Get(stage, "/Wall/Look/Surface")
    for name, value in numbers.items():
        surface.CreateInput(name, T.Float).Set(value)
    surface.CreateInput("opacityMode", T.Token).Set("presence")
    stage.Save()
    report, _ = convert(file, tmp_path / "out" / "wall.usda", Options(up_axis="Z"))
    assert report.notes == []
    converted = Usd.Stage.Open(str(tmp_path / "out" / "wall.usda"))
    [surface] = [UsdShade.Shader(prim) for prim in converted.Traverse() if prim.GetName() == "Surface"]
    assert {name: surface.GetInput(name).Get() for name in numbers} == numbers
    assert surface.GetInput("opacityMode").Get() == "presence"
