"""A stage of many prims of which a script edits all at once: meshes with primvars, OmniPBR materials, lights."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, Vt

from usdsdg.stage.attribute_batch import AttributeBatch
from usdsdg.stage.materials import define_mdl, set_input
from usdsdg.stage.semantics.labels import add_labels

MESHES, MATERIALS, LIGHTS, SIDE = 1000, 300, 300, 12
CAMERA = "/World/Camera"


class ManyPrims:
    """The stage, and edits of all prims of a kind at once. `k`, the number of the round, makes each edit another one.

    Args:
        folder: for texture files.
    """

    def __init__(self, folder: Path) -> None:
        self.stage = stage = Usd.Stage.CreateInMemory()
        self.rng = np.random.default_rng(3)
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        self.textures = [_write_texture(folder / f"texture_{k}.png", self.rng) for k in range(20)]
        self.meshes = [_add_mesh(stage, f"/World/Meshes/mesh_{k}", self.rng) for k in range(MESHES)]
        self.materials = [self._add_material(k) for k in range(MATERIALS)]
        self.lights = [self._add_light(k) for k in range(LIGHTS)]
        camera = UsdGeom.Camera.Define(stage, CAMERA)
        camera.AddTranslateOp().Set(Gf.Vec3d(0, 0, 60))
        self._batches: dict[str, AttributeBatch] = {}

    def _add_material(self, k: int) -> Usd.Prim:
        material = define_mdl(self.stage, f"/World/Looks/look_{k}", "OmniPBR.mdl").GetPrim()
        set_input(material, "diffuse_color_constant", self.rng.random(3).tolist())
        set_input(material, "reflection_roughness_constant", 0.4)
        if k % 3 == 0:
            set_input(material, "diffuse_texture", self.textures[k % len(self.textures)])
        ball = UsdGeom.Sphere.Define(self.stage, f"/World/Balls/ball_{k}")
        ball.AddTranslateOp().Set(Gf.Vec3d(*self.rng.uniform(-20, 20, 3).tolist()))
        UsdShade.MaterialBindingAPI.Apply(ball.GetPrim()).Bind(UsdShade.Material(material))
        return material

    def _add_light(self, k: int) -> Usd.Prim:
        light = UsdLux.SphereLight.Define(self.stage, f"/World/Lights/light_{k}")
        light.CreateIntensityAttr(1000)
        light.CreateColorAttr(Gf.Vec3f(1))
        light.CreateRadiusAttr(0.1)
        light.AddTranslateOp().Set(Gf.Vec3d(*self.rng.uniform(-20, 20, 3).tolist()))
        return light.GetPrim()

    def move(self, _: int) -> None:
        self._batch("xformOp:translate", self.meshes).write(self.rng.uniform(-20, 20, (MESHES, 3)))

    def recolor(self, _: int) -> None:
        self._set_arrays("primvars:displayColor", Vt.Vec3fArray, self.rng.random((MESHES, 1, 3)))

    def recolor_and_move(self, k: int) -> None:
        self.recolor(k)
        self.move(k)

    def fade(self, _: int) -> None:
        self._set_arrays("primvars:displayOpacity", Vt.FloatArray, self.rng.random((MESHES, 1)))

    def recolor_points(self, _: int) -> None:
        """Give each point of the first hundred meshes a color of its own, which makes them textures."""
        self._set_arrays("primvars:displayColor", Vt.Vec3fArray, self.rng.random((100, SIDE**2, 3)), "vertex")

    def unwrap(self, _: int) -> None:
        self._set_arrays("primvars:st", Vt.Vec2fArray, self.rng.random((MESHES, SIDE**2, 2)))

    def show(self, k: int) -> None:
        """Hide or show every other mesh."""
        shown = [["inherited", "invisible"][(k + each) % 2] for each in range(MESHES)]
        self._batch("visibility", self.meshes).write(shown)

    def label(self, k: int) -> None:
        for each, prim in enumerate(self.meshes):
            add_labels(prim, {"class": f"kind_{(each + k) % 20}"}, mode="replace")

    def paint(self, _: int) -> None:
        self._batch("inputs:diffuse_color_constant", self._shaders()).write(self.rng.random((MATERIALS, 3)))

    def roughen(self, _: int) -> None:
        self._batch("inputs:reflection_roughness_constant", self._shaders()).write(self.rng.random(MATERIALS))

    def swap_textures(self, k: int) -> None:
        with Sdf.ChangeBlock():
            for each, shader in enumerate(self._shaders()[::3]):
                file = self.textures[(k + each) % len(self.textures)]
                shader.GetAttribute("inputs:diffuse_texture").Set(Sdf.AssetPath(file))

    def bind(self, k: int) -> None:
        with Sdf.ChangeBlock():
            for each in range(MATERIALS):
                binding = self.stage.GetPrimAtPath(f"/World/Balls/ball_{each}").GetRelationship("material:binding")
                binding.SetTargets([self.materials[(each + k) % MATERIALS].GetPath()])

    def dim(self, _: int) -> None:
        self._batch("inputs:intensity", self.lights).write(self.rng.uniform(500, 2000, LIGHTS))

    def tint(self, _: int) -> None:
        self._batch("inputs:color", self.lights).write(self.rng.random((LIGHTS, 3)))

    def look(self, k: int) -> None:
        self.stage.GetAttributeAtPath(f"{CAMERA}.xformOp:translate").Set(Gf.Vec3d(0.1 * k, 0, 60))
        UsdGeom.Camera(self.stage.GetPrimAtPath(CAMERA)).CreateFocalLengthAttr().Set(20.0 + k)

    def _shaders(self) -> list[Usd.Prim]:
        return [material.GetChild("Shader") for material in self.materials]

    def _batch(self, name: str, prims: Sequence[Usd.Prim]) -> AttributeBatch:
        if name not in self._batches:
            self._batches[name] = AttributeBatch([prim.GetAttribute(name) for prim in prims])
        return self._batches[name]

    def _set_arrays(self, name: str, array: type, rows: np.ndarray, interpolation: str = "") -> None:
        with Sdf.ChangeBlock():
            for prim, values in zip(self.meshes, rows.astype(np.float32)):
                attribute = prim.GetAttribute(name)
                attribute.Set(array.FromNumpy(values))
                if interpolation and attribute.GetMetadata("interpolation") != interpolation:
                    attribute.SetMetadata("interpolation", interpolation)


def _write_texture(file: Path, rng: np.random.Generator) -> str:
    Image.fromarray(rng.integers(0, 256, (64, 64, 3), np.uint8)).save(file)
    return str(file)


def _add_mesh(stage: Usd.Stage, path: str, rng: np.random.Generator) -> Usd.Prim:
    """Add a bent sheet of 242 triangles that no other mesh equals, with all primvars that `ManyPrims` edits."""
    mesh = UsdGeom.Mesh.Define(stage, path)
    u, v = np.meshgrid(*[np.linspace(-1, 1, SIDE)] * 2)
    points = np.stack([u, v, rng.uniform(-0.1, 0.1, u.shape)], -1).reshape(-1, 3).astype(np.float32)
    corner = (np.arange(SIDE - 1)[:, None] * SIDE + np.arange(SIDE - 1)).reshape(-1)
    quads = np.stack([corner, corner + 1, corner + SIDE + 1, corner + SIDE], -1).reshape(-1).astype(np.int32)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full((SIDE - 1) ** 2, 4, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(quads))
    mesh.CreateSubdivisionSchemeAttr("none")
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex")
    st.Set(Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(points[:, :2])))
    mesh.CreateDisplayColorAttr([Gf.Vec3f(*rng.random(3).tolist())])
    mesh.CreateDisplayOpacityAttr([1.0])
    mesh.CreateVisibilityAttr("inherited")
    mesh.AddTranslateOp().Set(Gf.Vec3d(*rng.uniform(-20, 20, 3).tolist()))
    return mesh.GetPrim()
