"""The benchmark scene as of a randomizing script: textures, lights, a sky, labels, a point instancer and variants.

Beside the 337 objects of `render_stage` there are a point instancer and an object whose variants are two meshes.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, Vt

from benchmarks.render_scene import build, bumpy
from benchmarks.render_stage import author, write_asset
from usdsdg.stage.semantics.labels import add_labels

TEXTURED, FILES, POINTS = 40, 40, 100
TEXTURE_SIZE, SKY_SIZE = 512, (512, 1024)
CAMERA = "/World/Camera"


@dataclass
class World:
    """A stage, and what is needed to edit it."""

    stage: Usd.Stage
    ops: list[Usd.Attribute]  # transforms of the objects
    textures: list[str]  # texture files of the same size
    skies: list[str]
    asset: str  # a mesh that the stage does not have yet

    def surface(self, k: int) -> UsdShade.Shader:
        """Return the surface shader of an object's own material."""
        return UsdShade.Shader(self.stage.GetPrimAtPath(f"/World/object_{k}/Look/Surface"))

    def file(self, k: int) -> UsdShade.Input:
        """Return the texture file input of an object that has one."""
        return UsdShade.Shader(self.stage.GetPrimAtPath(f"/World/object_{k}/Look/Texture")).GetInput("file")

    def new_texture(self, number: int) -> str:
        """Write a new texture file, since files that were read before are cached."""
        file = Path(self.textures[0]).with_name(f"new_{number}.png")
        return _write_texture(file, np.random.default_rng(number))

    def new_sky(self, number: int) -> str:
        file = Path(self.skies[0]).with_name(f"new_{number}.hdr")
        return _write_sky(file, np.random.default_rng(number))

    def attribute(self, path: str) -> Usd.Attribute:
        return self.stage.GetAttributeAtPath(path)


def make_world(folder: Path) -> World:
    """Create the stage, with files in `folder`."""
    rng = np.random.default_rng(3)
    scene = build()
    stage, ops = author(scene, folder)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    textures = [_write_texture(folder / f"texture_{k}.png", rng) for k in range(FILES)]
    skies = [_write_sky(folder / f"sky_{k}.hdr", rng) for k in range(2)]
    for k in range(len(ops)):
        shader = UsdShade.Shader(stage.GetPrimAtPath(f"/World/object_{k}/Look/Surface"))
        shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*rng.random(3).tolist()))
        add_labels(stage.GetPrimAtPath(f"/World/object_{k}"), {"class": f"kind_{k % 15}"})
    for k in range(TEXTURED):
        _add_texture(stage, k, textures[k % FILES])
    _add_lights(stage, rng, skies[0])
    camera = UsdGeom.Camera.Define(stage, CAMERA)
    camera.AddTranslateOp().Set(Gf.Vec3d(0, 0, 6))
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.01, 1e5))
    _add_points(stage, rng)
    assets = [write_asset(folder, bumpy(rng, 10_000, f"/extra_{k}")) for k in range(3)]
    _add_variants(stage, assets[:2])
    return World(stage, ops, textures, skies, assets[2])


def _write_texture(file: Path, rng: np.random.Generator) -> str:
    coarse = rng.integers(0, 256, (16, 16, 3), np.uint8)
    Image.fromarray(coarse).resize((TEXTURE_SIZE, TEXTURE_SIZE)).save(file)
    return str(file)


def _write_sky(file: Path, rng: np.random.Generator) -> str:
    """Write a Radiance image without run lengths: a mantissa for each channel, and their exponent."""
    height, width = SKY_SIZE
    coarse = rng.integers(64, 256, (16, 32, 4), np.uint8)
    coarse[..., 3] = 129
    rows = np.repeat(np.repeat(coarse, height // 16, 0), width // 32, 1)
    file.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + f"-Y {height} +X {width}\n".encode() + rows.tobytes())
    return str(file)


def _add_texture(stage: Usd.Stage, k: int, file: str) -> None:
    texture = UsdShade.Shader.Define(stage, f"/World/object_{k}/Look/Texture")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(file)
    surface = UsdShade.Shader(stage.GetPrimAtPath(f"/World/object_{k}/Look/Surface"))
    surface.GetInput("diffuseColor").ConnectToSource(texture.ConnectableAPI(), "rgb")


def _add_lights(stage: Usd.Stage, rng: np.random.Generator, sky: str) -> None:
    UsdLux.DistantLight.Define(stage, "/World/Sun").CreateIntensityAttr(1000)
    for k, position in enumerate(rng.uniform(-2, 2, (3, 3)).tolist()):
        lamp = UsdLux.SphereLight.Define(stage, f"/World/Lamp_{k}")
        lamp.CreateIntensityAttr(30000)
        lamp.CreateColorAttr(Gf.Vec3f(1, 0.9, 0.8))
        lamp.CreateRadiusAttr(0.1)
        lamp.AddTranslateOp().Set(Gf.Vec3d(*position))
    dome = UsdLux.DomeLight.Define(stage, "/World/Sky")
    dome.CreateIntensityAttr(500)
    dome.CreateTextureFileAttr(sky)


def _add_points(stage: Usd.Stage, rng: np.random.Generator) -> None:
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Points")
    UsdGeom.Sphere.Define(stage, "/World/Points/Ball").CreateRadiusAttr(0.02)
    instancer.CreatePrototypesRel().SetTargets(["/World/Points/Ball"])
    instancer.CreateProtoIndicesAttr([0] * POINTS)
    instancer.CreatePositionsAttr(positions(rng))


def positions(rng: np.random.Generator) -> Vt.Vec3fArray:
    """Return random positions of all points."""
    return Vt.Vec3fArray.FromNumpy(rng.uniform(-2, 2, (POINTS, 3)).astype(np.float32))


def _add_variants(stage: Usd.Stage, files: list[str]) -> None:
    prim = UsdGeom.Xform.Define(stage, "/World/Varied").GetPrim()
    variants = prim.GetVariantSets().AddVariantSet("shape")
    for name, file in zip("ab", files, strict=True):
        variants.AddVariant(name)
        variants.SetVariantSelection(name)
        with variants.GetVariantEditContext():
            prim.GetReferences().AddReference(file)
    variants.SetVariantSelection("a")
