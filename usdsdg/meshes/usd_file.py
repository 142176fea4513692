"""A mesh as a USD file: one Mesh prim for each part, UsdPreviewSurface materials, pictures beside it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade, Vt

from usdsdg.meshes.model import Material, MeshFile, Part, Texture
from usdsdg.meshes.repairs import with_normals
from usdsdg.stage import paths
from usdsdg.stage.semantics.labels import add_labels
from usdsdg.stage.usd_errors import save


def textures_of(file: Path) -> str:
    """Return the folder of the pictures of a file, relative to it: files beside it have materials of the same names."""
    return f"textures/{file.stem}"


def write_usd(
    mesh: MeshFile,
    file: Path,
    *,
    name: str,
    up_axis: str,
    meters_per_unit: float,
    label: str | None,
    collider: str | None,
) -> None:
    """Write `mesh`, which has this up axis and these units already, with its pictures in `textures_of` the file.

    name: of the default prim. label: its class; None: no label. collider: an approximation of UsdPhysics, or None.
    """
    stage = Usd.Stage.CreateNew(str(file))
    UsdGeom.SetStageUpAxis(stage, up_axis)
    UsdGeom.SetStageMetersPerUnit(stage, meters_per_unit)
    root = UsdGeom.Xform.Define(stage, f"/{paths.valid_name(name)}")
    stage.SetDefaultPrim(root.GetPrim())
    Usd.ModelAPI(root.GetPrim()).SetKind("component")
    if label:
        add_labels(root.GetPrim(), {"class": [label]})
    looks = _Looks(stage, root.GetPath(), file)
    materials = [looks.add(material) for material in mesh.materials]
    for part in mesh.parts:
        path = paths.next_free_path(stage, str(root.GetPath().AppendChild(paths.valid_name(part.name))))
        prim = _define_mesh(stage, path, part)
        if part.material is not None:
            UsdShade.MaterialBindingAPI.Apply(prim).Bind(materials[part.material])
        if collider is not None:
            UsdPhysics.CollisionAPI.Apply(prim)
            UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr(collider)
    save(stage.GetRootLayer())


def _define_mesh(stage: Usd.Stage, path: str, part: Part) -> Usd.Prim:
    part = with_normals(part)
    used = part.used_points
    corners = (np.cumsum(used) - 1)[part.triangles]
    mesh = UsdGeom.Mesh.Define(stage, path)
    points = part.points[used].astype(np.float32)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points)))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray(len(part.triangles), 3))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(corners.ravel().astype(np.int32)))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDoubleSidedAttr(part.is_double_sided)
    mesh.CreateExtentAttr(Vt.Vec3fArray([Gf.Vec3f(*map(float, each)) for each in (points.min(0), points.max(0))]))
    if part.normals is not None:
        values, interpolation = _as_primvar(part.normals, part, used)
        mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(values))
        mesh.SetNormalsInterpolation(interpolation)
    primvars = UsdGeom.PrimvarsAPI(mesh)
    if part.uvs is not None:
        values, interpolation = _as_primvar(part.uvs, part, used)
        st = primvars.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, interpolation)
        st.Set(Vt.Vec2fArray.FromNumpy(values))
    if part.colors is not None:
        values, interpolation = _as_primvar(part.colors, part, used)
        mesh.CreateDisplayColorPrimvar(interpolation).Set(Vt.Vec3fArray.FromNumpy(values))
    return mesh.GetPrim()


def _as_primvar(values: np.ndarray, part: Part, used: np.ndarray) -> tuple[np.ndarray, str]:
    """Return values per point that is used, or per corner, and USD's word for it."""
    is_per_point = len(values) == len(part.points)
    chosen = values[used] if is_per_point else values
    return np.ascontiguousarray(chosen.astype(np.float32)), "vertex" if is_per_point else "faceVarying"


_DEFAULTS = Material()


class _Looks:
    """The materials of one file, and the pictures that they share."""

    def __init__(self, stage: Usd.Stage, root: Sdf.Path, file: Path) -> None:
        self._stage, self._file = stage, file
        self._scope = root.AppendChild("Looks")
        self._files: dict[int, str] = {}  # by id of the picture

    def add(self, given: Material) -> UsdShade.Material:
        """Define a UsdPreviewSurface material."""
        if not self._stage.GetPrimAtPath(self._scope):
            UsdGeom.Scope.Define(self._stage, self._scope)
        path = paths.next_free_path(self._stage, str(self._scope.AppendChild(paths.valid_name(given.name))))
        material = UsdShade.Material.Define(self._stage, path)
        surface = UsdShade.Shader.Define(self._stage, f"{path}/Surface")
        surface.CreateIdAttr("UsdPreviewSurface")
        material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
        network = _Network(self._stage, path, surface)
        color = self._picture(network, given.color_texture, "color", scale=(*given.color, given.opacity))
        if given.color_from_points:
            network.set_from_points("diffuseColor")
        else:
            network.set("diffuseColor", Sdf.ValueTypeNames.Color3f, Gf.Vec3f(*given.color), color, "rgb")
        if given.opacity_from_color:
            network.set("opacity", Sdf.ValueTypeNames.Float, given.opacity, color, "a")
        else:
            mask = self._picture(network, given.opacity_texture, "opacity", scale=(given.opacity, 1.0, 1.0, 1.0))
            network.set("opacity", Sdf.ValueTypeNames.Float, given.opacity, mask, "r")
        if given.opacity_threshold > 0.0:
            network.set("opacityThreshold", Sdf.ValueTypeNames.Float, given.opacity_threshold)
        if given.is_presence:
            network.set("opacityMode", Sdf.ValueTypeNames.Token, "presence")
        if given.ior != _DEFAULTS.ior:
            network.set("ior", Sdf.ValueTypeNames.Float, given.ior)
        if given.clearcoat > 0.0:
            network.set("clearcoat", Sdf.ValueTypeNames.Float, given.clearcoat)
            network.set("clearcoatRoughness", Sdf.ValueTypeNames.Float, given.clearcoat_roughness)
        if given.specular is None:
            self._set_metallic(network, given)
        else:
            self._set_specular(network, given, given.specular)
        glow = self._picture(network, given.emission_texture, "emission", scale=(*given.emission, 1.0))
        if any(given.emission):
            network.set("emissiveColor", Sdf.ValueTypeNames.Color3f, Gf.Vec3f(*given.emission), glow, "rgb")
        steep = given.normal_scale
        normal = self._picture(
            network, given.normal_texture, "normal", scale=(2.0 * steep, 2.0 * steep, 2.0, 1.0),
            bias=(-steep, -steep, -1.0, 0.0),
        )  # fmt: skip
        if normal is not None:
            network.set("normal", Sdf.ValueTypeNames.Normal3f, None, normal, "rgb")
        occlusion = self._picture(network, given.occlusion_texture, "occlusion")
        if occlusion is not None:
            network.set("occlusion", Sdf.ValueTypeNames.Float, None, occlusion, "r")
        return material

    def _set_metallic(self, network: _Network, given: Material) -> None:
        factors = (1.0, given.roughness, given.metallic, 1.0)
        rough = self._picture(network, given.roughness_texture, "roughness", scale=factors)
        metal = rough
        if given.metallic_texture != given.roughness_texture:
            metal = self._picture(network, given.metallic_texture, "metallic", scale=factors)
        network.set("metallic", Sdf.ValueTypeNames.Float, given.metallic, metal, "b")
        network.set("roughness", Sdf.ValueTypeNames.Float, given.roughness, rough, "g")

    def _set_specular(self, network: _Network, given: Material, specular: tuple[float, float, float]) -> None:
        glossy, glossiness = given.glossy_texture, 1.0 - given.roughness
        color = self._picture(network, glossy and replace(glossy, is_color=True), "specular", scale=(*specular, 1.0))
        rough = self._picture(
            network, glossy, "roughness", scale=(1.0, 1.0, 1.0, -glossiness), bias=(0.0, 0.0, 0.0, 1.0)
        )
        network.set("useSpecularWorkflow", Sdf.ValueTypeNames.Int, 1)
        network.set("specularColor", Sdf.ValueTypeNames.Color3f, Gf.Vec3f(*specular), color, "rgb")
        network.set("roughness", Sdf.ValueTypeNames.Float, given.roughness, rough, "a")

    def _picture(
        self,
        network: _Network,
        texture: Texture | None,
        role: str,
        *,
        scale: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0),
        bias: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0),
    ) -> UsdShade.Shader | None:
        if texture is None:
            return None
        return network.picture(role, self._saved(texture), texture, scale=scale, bias=bias)

    def _saved(self, texture: Texture) -> str:
        """Write a picture, once, and return its path relative to the USD file."""
        if id(texture.image) not in self._files:
            place = textures_of(self._file)
            folder = self._file.parent / place
            folder.mkdir(parents=True, exist_ok=True)
            stem, count = paths.valid_name(texture.name), len(self._files)
            name = f"{stem}.png" if not (folder / f"{stem}.png").exists() else f"{stem}_{count}.png"
            image = texture.image
            if image.mode not in ("L", "LA", "RGB", "RGBA", "I;16"):
                image = image.convert("RGBA" if "A" in image.getbands() or "transparency" in image.info else "RGB")
            image.save(folder / name, "PNG")
            self._files[id(texture.image)] = f"./{place}/{name}"
        return self._files[id(texture.image)]


class _Network:
    """The shaders of one material."""

    def __init__(self, stage: Usd.Stage, material: str, surface: UsdShade.Shader) -> None:
        self._stage, self._material, self._surface = stage, material, surface
        self._reader: UsdShade.Shader | None = None

    def set(
        self,
        name: str,
        kind: Sdf.ValueTypeName,
        value: object = None,
        picture: UsdShade.Shader | None = None,
        output: str = "rgb",
    ) -> None:
        """Set an input of the surface: a value, or where there is a picture, one of its outputs."""
        entry = self._surface.CreateInput(name, kind)
        if picture is not None:
            kinds = {"rgb": Sdf.ValueTypeNames.Float3}
            made = picture.CreateOutput(output, kinds.get(output, Sdf.ValueTypeNames.Float))
            entry.ConnectToSource(made)
        elif value is not None:
            entry.Set(value)

    def set_from_points(self, name: str) -> None:
        """Let an input of the surface be the displayColor of the mesh."""
        reader = UsdShade.Shader.Define(self._stage, f"{self._material}/displayColor")
        reader.CreateIdAttr("UsdPrimvarReader_float3")
        reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("displayColor")
        entry = self._surface.CreateInput(name, Sdf.ValueTypeNames.Color3f)
        entry.ConnectToSource(reader.CreateOutput("result", Sdf.ValueTypeNames.Float3))

    def picture(
        self, role: str, file: str, given: Texture, *, scale: tuple[float, ...], bias: tuple[float, ...]
    ) -> UsdShade.Shader:
        """Define a UsdUVTexture with st as its coordinates."""
        shader = UsdShade.Shader.Define(self._stage, f"{self._material}/{role}")
        shader.CreateIdAttr("UsdUVTexture")
        shader.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(Sdf.AssetPath(file))
        shader.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set("sRGB" if given.is_color else "raw")
        for name, wrap in zip(("wrapS", "wrapT"), given.wraps):
            shader.CreateInput(name, Sdf.ValueTypeNames.Token).Set(wrap)
        if any(each != 1.0 for each in scale):
            shader.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(*scale))
        if any(bias):
            shader.CreateInput("bias", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(*bias))
        shader.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(self._coordinates())
        return shader

    def _coordinates(self) -> UsdShade.Output:
        reader = self._reader
        if reader is None:
            reader = self._reader = UsdShade.Shader.Define(self._stage, f"{self._material}/st")
            reader.CreateIdAttr("UsdPrimvarReader_float2")
            reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
        return reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
