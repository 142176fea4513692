"""Write demo assets as USD layers: meshes, material subsets, preview surfaces and their textures."""

import os
from pathlib import Path

import numpy as np
from pxr import Gf, Kind, Sdf, Tf, Usd, UsdGeom, UsdPhysics, UsdShade, Vt

from usdsdg.demo.asset import Asset, Material
from usdsdg.demo.shapes.surface import Surface, joined
from usdsdg.stage.usd_errors import save


def write_asset(path: Path, asset: Asset) -> None:
    """Write an asset to a `.usd` file (meters, Z up), and its textures to the folder `textures` beside it."""
    stage = new_stage(path, asset.kind)
    root = stage.GetDefaultPrim()
    material_scope = UsdGeom.Scope.Define(stage, root.GetPath().AppendChild("Looks")).GetPath()
    materials = {
        name: _write_material(stage, material_scope.AppendChild(name), material, path)
        for name, material in asset.materials.items()
    }
    offset = _offset_to_origin(asset)
    for name, surfaces in asset.bodies.items():
        placed = [surface.moved(*offset) for surface in surfaces]
        _write_mesh(stage, root.GetPath().AppendChild(name), placed, materials)
    _write_extents_hint(root)
    save(stage.GetRootLayer())


def write_physics_variant(path: Path, sibling: Path, mass: float) -> None:
    """Write a layer that references `sibling` as a rigid body of `mass` [kg] with convex-hull colliders."""
    stage = new_stage(path, Kind.Tokens.component)
    root = stage.GetDefaultPrim()
    root.GetReferences().AddReference(os.path.relpath(sibling, path.parent).replace(os.sep, "/"))
    UsdPhysics.RigidBodyAPI.Apply(root)
    UsdPhysics.MassAPI.Apply(root).CreateMassAttr(mass)
    for prim in Usd.PrimRange(root):
        if prim.IsA(UsdGeom.Mesh):
            UsdPhysics.CollisionAPI.Apply(prim)
            UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr(UsdPhysics.Tokens.convexHull)
    save(stage.GetRootLayer())


def valid_name(path: Path) -> str:
    """Return the prim name for a file name; an underscore precedes a leading digit."""
    return Tf.MakeValidIdentifier(path.stem if not path.stem[0].isdigit() else f"_{path.stem}")


def new_stage(path: Path, kind: str) -> Usd.Stage:
    """Make a file (meters, Z up) whose default prim, an Xform of that kind, has the name of the file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, Sdf.Path("/").AppendChild(valid_name(path))).GetPrim()
    stage.SetDefaultPrim(root)
    Usd.ModelAPI(root).SetKind(kind)
    stage.GetRootLayer().customLayerData = {"source": "usdsdg demo stand-in, made by code", "license": "CC0-1.0"}
    return stage


def _offset_to_origin(asset: Asset) -> tuple[float, float, float]:
    points = np.concatenate([surface.points for surfaces in asset.bodies.values() for surface in surfaces])
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2.0
    return (-middle[0], -middle[1], -(low[2] if asset.origin_at_bottom else middle[2]))


def _write_mesh(
    stage: Usd.Stage, path: Sdf.Path, surfaces: list[Surface], materials: dict[str, UsdShade.Material]
) -> None:
    merged = joined(surfaces)
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(merged.points.astype(np.float32)))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(merged.counts.astype(np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(merged.indices.astype(np.int32)))
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(merged.normals.astype(np.float32)))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.faceVarying)
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    extent = np.stack([merged.points.min(axis=0), merged.points.max(axis=0)]).astype(np.float32)
    mesh.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(extent))
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying)
    st.Set(Vt.Vec2fArray.FromNumpy(merged.st.astype(np.float32)))
    _bind(mesh, surfaces, materials)


def _bind(mesh: UsdGeom.Mesh, surfaces: list[Surface], materials: dict[str, UsdShade.Material]) -> None:
    """Bind a single material to the mesh, several to one GeomSubset each."""
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
    if material.texture is None:
        diffuse.Set(Gf.Vec3f(*material.color))
    else:
        diffuse.ConnectToSource(_write_texture(stage, path, material, layer_path).ConnectableAPI(), "rgb")
    if any(material.emissive):
        surface.CreateInput("emissiveColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*material.emissive))
    prim.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    return prim


def _write_texture(stage: Usd.Stage, path: Sdf.Path, material: Material, layer_path: Path) -> UsdShade.Shader:
    assert material.texture is not None
    file = Path("textures") / f"{layer_path.stem}_{path.name}.png"
    (layer_path.parent / "textures").mkdir(exist_ok=True)
    material.texture().save(layer_path.parent / file, compress_level=1)
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


def _write_extents_hint(root: Usd.Prim) -> None:
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_])
    UsdGeom.ModelAPI.Apply(root).SetExtentsHint(UsdGeom.ModelAPI(root).ComputeExtentsHint(cache))
