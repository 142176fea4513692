"""The benchmark scene as a USD stage: a crate file for each prototype, and objects that reference them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

import usdsdg.stage  # first: it registers schemas  # noqa: F401
from usdsdg_render.scene.scene import Prototype, Scene


def author(scene: Scene, folder: Path) -> tuple[Usd.Stage, list[Usd.Attribute]]:
    """Author the scene's objects as references with a material each; return the stage and transform attributes."""
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


def write_asset(folder: Path, prototype: Prototype) -> str:
    """Write a prototype as a crate file with one mesh below its default prim; return its path."""
    file = str(folder / f"{prototype.name.strip('/')}.usdc")
    stage = Usd.Stage.CreateNew(file)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Asset").GetPrim())
    mesh = UsdGeom.Mesh.Define(stage, "/Asset/Mesh")
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(prototype.points))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray(len(prototype.triangles), 3))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(prototype.triangles.ravel()))
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(prototype.normals.reshape(-1, 3)))
    mesh.SetNormalsInterpolation("faceVarying")
    uvs = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying")
    uvs.Set(Vt.Vec2fArray.FromNumpy(prototype.uvs.reshape(-1, 2)))
    mesh.CreateSubdivisionSchemeAttr("none")
    stage.Save()
    return file


def random_poses(count: int, seed: int) -> np.ndarray:
    """Return (count, 4, 4) float64 translations of about a stage unit, row vectors."""
    matrices = np.tile(np.eye(4), (count, 1, 1))
    matrices[:, 3, :3] = np.random.default_rng(seed).normal(size=(count, 3))
    return matrices


def write_poses(ops: list[Usd.Attribute], matrices: np.ndarray) -> None:
    """Set the transforms of all objects in one change of the stage."""
    with Sdf.ChangeBlock():
        for op, matrix in zip(ops, matrices.tolist(), strict=True):
            op.Set(Gf.Matrix4d(matrix))
