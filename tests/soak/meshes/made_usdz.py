"""Packages as photogrammetry writes them: Y up, centimeters or meters, pictures inside, and no collider."""

from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, Vt

from tests.soak.meshes.cases import makes
from tests.soak.meshes.shapes import checker, cup, textured_box


def package(
    file: Path, mesh: Any, *, unit: float = 0.01, up: str = "Y", picture: bool = True, split: bool = False,
    at: tuple[float, float, float] = (0.0, 0.0, 0.0), edit: Any = None,
) -> None:  # fmt: skip
    """Write a .usdz with one mesh, given in meters with Z up, as a scan: UVs by corner, and three pictures."""
    stage = Usd.Stage.CreateNew(str(file.parent / "scan.usdc"))
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    root = UsdGeom.Xform.Define(stage, "/scan")
    stage.SetDefaultPrim(root.GetPrim())
    root.AddTranslateOp().Set(Gf.Vec3d(*at))
    made = UsdGeom.Mesh.Define(stage, "/scan/Geom/object")
    points = np.asarray(mesh.vertices) / unit
    points = points[:, [0, 2, 1]] * (1, 1, -1) if up == "Y" else points
    faces = np.asarray(mesh.faces)
    made.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.float32(points)))
    made.CreateFaceVertexCountsAttr(Vt.IntArray(len(faces), 3))
    made.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.int32(faces).ravel()))
    made.CreateSubdivisionSchemeAttr("none")
    uv = getattr(mesh.visual, "uv", None)
    uv = np.asarray(mesh.vertices)[:, :2] * 5 if uv is None else np.asarray(uv)
    st = UsdGeom.PrimvarsAPI(made).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying")
    st.Set(Vt.Vec2fArray.FromNumpy(np.float32(uv[faces.ravel()])))
    looks = [look(stage, "/scan/Looks/skin", file.parent if picture else None)]
    UsdShade.MaterialBindingAPI.Apply(made.GetPrim()).Bind(looks[0])
    if split:
        second = look(stage, "/scan/Looks/plain", None)
        half = Vt.IntArray.FromNumpy(np.arange(len(faces) // 2, dtype=np.int32))
        subset = UsdShade.MaterialBindingAPI(made).CreateMaterialBindSubset("lower", half)
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(second)
    if edit is not None:
        edit(stage)
    stage.GetRootLayer().Save()
    writer = Sdf.ZipFileWriter.CreateNew(str(file))
    for each in (file.parent / "scan.usdc", *sorted(file.parent.glob("tex*.png"))):
        writer.AddFile(str(each), each.name)
        each.unlink()
    writer.Save()


def look(stage: Usd.Stage, path: str, folder: Path | None) -> UsdShade.Material:
    """Define a material; with a folder its color, normals and roughness are pictures."""
    material = UsdShade.Material.Define(stage, path)
    surface = UsdShade.Shader.Define(stage, f"{path}/surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    if folder is None:
        surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set((0.7, 0.2, 0.2))
        return material
    checker(256).save(folder / "tex0.png")
    Image.new("RGB", (8, 8), (128, 128, 255)).save(folder / "tex1.png")
    Image.new("L", (16, 16), 200).save(folder / "tex2.png")
    reader = UsdShade.Shader.Define(stage, f"{path}/uv")
    reader.CreateIdAttr("UsdPrimvarReader_float2")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
    kinds = {"diffuseColor": ("rgb", "sRGB"), "normal": ("rgb", "raw"), "roughness": ("r", "raw")}
    for number, (name, (output, space)) in enumerate(kinds.items()):
        texture = UsdShade.Shader.Define(stage, f"{path}/{name}")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(Sdf.AssetPath(f"tex{number}.png"))
        texture.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set(space)
        texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(
            reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
        )
        kind = Sdf.ValueTypeNames.Float if output == "r" else Sdf.ValueTypeNames.Color3f
        made = texture.CreateOutput(output, Sdf.ValueTypeNames.Float if output == "r" else Sdf.ValueTypeNames.Float3)
        surface.CreateInput(name, kind).ConnectToSource(made)
    return material


@makes("scan_cm.usdz")
def _(file: Path) -> None:
    package(file, textured_box())


@makes("scan_m.usdz", "away from its origin")
def _(file: Path) -> None:
    package(file, cup(), unit=1.0, at=(3.0, 1.0, -2.0))


@makes("scan_z_mm.usdz")
def _(file: Path) -> None:
    package(file, cup(), unit=0.001, up="Z")


@makes("scan_parts.usdz")
def _(file: Path) -> None:
    package(file, textured_box(), split=True)


@makes("scan_left_handed.usdz")
def _(file: Path) -> None:
    def edit(stage: Usd.Stage) -> None:
        mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/scan/Geom/object"))
        mesh.CreateOrientationAttr("leftHanded")
        indices = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)[:, ::-1]
        mesh.GetFaceVertexIndicesAttr().Set(Vt.IntArray.FromNumpy(np.ascontiguousarray(indices).ravel()))
        st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
        values = np.array(st.Get()).reshape(-1, 3, 2)[:, ::-1].reshape(-1, 2)
        st.Set(Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(values)))

    package(file, textured_box(), edit=edit)


@makes("scan_claims_meters.usdz", "convert it with --unit")
def _(file: Path) -> None:
    package(file, cup(1000.0), unit=1.0)


@makes("light_and_scan.usdz", "left out: lights")
def _(file: Path) -> None:
    package(file, textured_box(), edit=lambda stage: UsdLux.SphereLight.Define(stage, "/scan/lamp"))


@makes("torn.usdz", "cannot be opened as USD", refused=True)
def _(file: Path) -> None:
    package(file, textured_box())
    file.write_bytes(file.read_bytes()[:3000])


@makes("no_mesh.usdz", "no triangles", refused=True)
def _(file: Path) -> None:
    package(file, textured_box(), edit=lambda stage: stage.RemovePrim("/scan/Geom"))


@makes("no_picture.usdz", "gone.png is missing")
def _(file: Path) -> None:
    def edit(stage: Usd.Stage) -> None:
        shader = UsdShade.Shader(stage.GetPrimAtPath("/scan/Looks/skin/diffuseColor"))
        shader.GetInput("file").Set(Sdf.AssetPath("gone.png"))

    package(file, textured_box(), edit=edit)
