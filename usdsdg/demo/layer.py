"""Assets written as USD layers: meshes, material subsets, preview surfaces, pictures."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from pxr import Gf, Kind, Sdf, Tf, Usd, UsdGeom, UsdPhysics, UsdShade, Vt

from usdsdg.demo.asset import Asset, Material
from usdsdg.demo.shapes.surface import Surface, joined


def write_asset(path: Path, asset: Asset) -> None:
    """Write an asset to a `.usd` file, its pictures to the folder `textures` beside it. Metres, Z up."""
    stage = _new_stage(path, asset.kind)
    root = stage.GetDefaultPrim()
    looks = UsdGeom.Scope.Define(stage, root.GetPath().AppendChild("Looks")).GetPath()
    materials = {
        name: _write_material(stage, looks.AppendChild(name), material, path)
        for name, material in asset.materials.items()
    }
    shift = _origin(asset)
    for name, surfaces in asset.bodies.items():
        placed = [surface.moved(*shift) for surface in surfaces]
        _write_mesh(stage, root.GetPath().AppendChild(name), placed, materials)
    _write_extents_hint(stage, root)
    stage.GetRootLayer().Save()


def write_physics_variant(path: Path, sibling: Path, mass: float) -> None:
    """Write a layer that references `sibling` and makes it a rigid body of `mass` [kg] with hull colliders."""
    stage = _new_stage(path, Kind.Tokens.component)
    root = stage.GetDefaultPrim()
    root.GetReferences().AddReference(os.path.relpath(sibling, path.parent).replace(os.sep, "/"))
    UsdPhysics.RigidBodyAPI.Apply(root)
    UsdPhysics.MassAPI.Apply(root).CreateMassAttr(mass)
    for prim in Usd.PrimRange(root):
        if prim.IsA(UsdGeom.Mesh):
            UsdPhysics.CollisionAPI.Apply(prim)
            UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr(UsdPhysics.Tokens.convexHull)
    stage.GetRootLayer().Save()


def valid_name(path: Path) -> str:
    """The prim name that a file name gives; one that starts with a digit gets an underscore before it."""
    return Tf.MakeValidIdentifier(path.stem if not path.stem[0].isdigit() else f"_{path.stem}")


def _new_stage(path: Path, kind: str) -> Usd.Stage:
    path.parent.mkdir(parents=True, exist_ok=True)
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, Sdf.Path("/").AppendChild(valid_name(path))).GetPrim()
    stage.SetDefaultPrim(root)
    Usd.ModelAPI(root).SetKind(kind)
    stage.GetRootLayer().customLayerData = {"source": "usdsdg demo stand-in, made by code", "license": "CC0-1.0"}
    return stage


def _origin(asset: Asset) -> tuple[float, float, float]:
    points = np.concatenate([surface.points for surfaces in asset.bodies.values() for surface in surfaces])
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2.0
    return (-middle[0], -middle[1], -(low[2] if asset.standing else middle[2]))


def _write_mesh(
    stage: Usd.Stage, path: Sdf.Path, surfaces: list[Surface], materials: dict[str, UsdShade.Material]
) -> None:
    whole = joined(surfaces)
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(whole.points.astype(np.float32)))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(whole.counts.astype(np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(whole.indices.astype(np.int32)))
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(whole.normals.astype(np.float32)))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.faceVarying)
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    extent = np.stack([whole.points.min(axis=0), whole.points.max(axis=0)]).astype(np.float32)
    mesh.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(extent))
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying)
    st.Set(Vt.Vec2fArray.FromNumpy(whole.st.astype(np.float32)))
    _bind(mesh, surfaces, materials)


def _bind(mesh: UsdGeom.Mesh, surfaces: list[Surface], materials: dict[str, UsdShade.Material]) -> None:
    """One material binds to the mesh; several bind to one subset of faces each."""
    owner = np.repeat([surface.material for surface in surfaces], [len(surface.counts) for surface in surfaces])
    names = list(dict.fromkeys(owner.tolist()))
    if len(names) == 1:
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(materials[names[0]])
        return
    for name in names:
        faces = Vt.IntArray.FromNumpy(np.flatnonzero(owner == name).astype(np.int32))
        subset = UsdGeom.Subset.CreateGeomSubset(mesh, name, UsdGeom.Tokens.face, faces)
        subset.CreateFamilyNameAttr(UsdShade.Tokens.materialBind)
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(materials[name])
    UsdGeom.Subset.SetFamilyType(mesh, UsdShade.Tokens.materialBind, UsdGeom.Tokens.partition)


def _write_material(stage: Usd.Stage, path: Sdf.Path, material: Material, layer_path: Path) -> UsdShade.Material:
    prim = UsdShade.Material.Define(stage, path)
    surface = UsdShade.Shader.Define(stage, path.AppendChild("Surface"))
    surface.CreateIdAttr("UsdPreviewSurface")
    for name, value in (
        ("roughness", material.roughness),
        ("metallic", material.metallic),
        ("clearcoat", material.clearcoat),
    ):
        surface.CreateInput(name, Sdf.ValueTypeNames.Float).Set(value)
    diffuse = surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
    if material.picture is None:
        diffuse.Set(Gf.Vec3f(*material.colour))
    else:
        diffuse.ConnectToSource(_write_picture(stage, path, material, layer_path).ConnectableAPI(), "rgb")
    if any(material.emissive):
        surface.CreateInput("emissiveColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*material.emissive))
    prim.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    return prim


def _write_picture(stage: Usd.Stage, path: Sdf.Path, material: Material, layer_path: Path) -> UsdShade.Shader:
    assert material.picture is not None
    file = Path("textures") / f"{layer_path.stem}_{path.name}.png"
    (layer_path.parent / "textures").mkdir(exist_ok=True)
    material.picture().save(layer_path.parent / file, compress_level=1)
    reader = UsdShade.Shader.Define(stage, path.AppendChild("Coordinates"))
    reader.CreateIdAttr("UsdPrimvarReader_float2")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
    texture = UsdShade.Shader.Define(stage, path.AppendChild("Picture"))
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(f"./{file.as_posix()}")
    texture.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set("sRGB")
    for axis in ("wrapS", "wrapT"):
        texture.CreateInput(axis, Sdf.ValueTypeNames.Token).Set("repeat")
    texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(reader.ConnectableAPI(), "result")
    texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)
    return texture


def _write_extents_hint(stage: Usd.Stage, root: Usd.Prim) -> None:
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_])
    UsdGeom.ModelAPI.Apply(root).SetExtentsHint(UsdGeom.ModelAPI(root).ComputeExtentsHint(cache))
