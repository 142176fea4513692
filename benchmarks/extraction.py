"""From USD to the renderer's tables: the whole benchmark scene, 337 new poses, and one character that bends.

python -m benchmarks.extraction
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

import usdsdg.stage  # first: it registers schemas  # noqa: F401
from benchmarks.render_scene import build
from tests.stage.characters import add_character
from usdsdg_render.extract import SceneExtractor
from usdsdg_render.scene import Prototype, Scene

REPEATS = 9


def write_asset(folder: Path, prototype: Prototype) -> str:
    """A prototype as a crate file with one mesh below its default prim."""
    file = str(folder / f"{prototype.name.strip('/')}.usdc")
    stage = Usd.Stage.CreateNew(file)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Asset").GetPrim())
    mesh = UsdGeom.Mesh.Define(stage, "/Asset/Mesh")
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(prototype.points))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray(len(prototype.triangles), 3))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(prototype.triangles.ravel()))
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(prototype.corner_normals.reshape(-1, 3)))
    mesh.SetNormalsInterpolation("faceVarying")
    uvs = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying")
    uvs.Set(Vt.Vec2fArray.FromNumpy(prototype.corner_uvs.reshape(-1, 2)))
    mesh.CreateSubdivisionSchemeAttr("none")
    stage.Save()
    return file


def author(scene: Scene, folder: Path) -> tuple[Usd.Stage, list[Usd.Attribute]]:
    """The scene's objects as references with a material each, and their transform attributes."""
    files = [write_asset(folder, prototype) for prototype in scene.prototypes]
    stage = Usd.Stage.CreateInMemory()
    ops = []
    with Sdf.ChangeBlock():
        layer = stage.GetRootLayer()
        for k, which in enumerate(scene.instances.prototype):
            spec = Sdf.CreatePrimInLayer(layer, f"/World/object_{k}")
            spec.specifier, spec.typeName = Sdf.SpecifierDef, "Xform"
            spec.referenceList.prependedItems = [Sdf.Reference(files[which])]
    for k, matrix in enumerate(scene.instances.local_to_world):
        prim = stage.GetPrimAtPath(f"/World/object_{k}")
        op = UsdGeom.Xformable(prim).AddTransformOp()
        op.Set(Gf.Matrix4d(matrix.tolist()))
        ops.append(op.GetAttr())
        material = UsdShade.Material.Define(stage, f"/World/object_{k}/Look")
        shader = UsdShade.Shader.Define(stage, f"/World/object_{k}/Look/Surface")
        shader.CreateIdAttr("UsdPreviewSurface")
        shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(k / 337)
        material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)
    return stage, ops


def milliseconds(work, repeats: int = REPEATS) -> float:
    """The best of some runs."""
    best = np.inf
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - begin)
    return 1000 * best


def main() -> None:
    scene = build()
    with tempfile.TemporaryDirectory() as folder:
        stage, ops = author(scene, Path(folder))
        print(f"extraction of {len(ops)} objects: {milliseconds(lambda: SceneExtractor(stage).update()):.0f} ms")
        extractor = SceneExtractor(stage)
        extractor.update()
        rng = np.random.default_rng(0)

        def poses() -> None:
            with Sdf.ChangeBlock():
                for op in ops:
                    op.Set(Gf.Matrix4d(1.0).SetTranslate(Gf.Vec3d(*rng.normal(size=3))))

        best = np.inf
        for _ in range(REPEATS):
            poses()
            best = min(best, milliseconds(extractor.update, 1))
        print(f"update of {len(ops)} poses: {best:.1f} ms")
        add_character(stage, "/World/Man")
        codes = iter(np.linspace(1, 23, REPEATS + 1))
        extractor.update(Usd.TimeCode(0))
        bending = milliseconds(lambda: extractor.update(Usd.TimeCode(next(codes))))
        print(f"a character that bends among them: {bending:.1f} ms")


if __name__ == "__main__":
    main()
