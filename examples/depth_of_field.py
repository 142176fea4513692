"""A path-traced image: preview materials under a painted sky, with depth of field focused by the depth label.

    python examples/depth_of_field.py [--out FOLDER] [--width PIXELS] [--samples N]

Shows UsdPreviewSurface, a dome light with a texture, and depth of field in the renderer alone: the depth of the ball in
the middle sets the focus distance. Writes picture.png, and scene.usda with its sky.png, which `usdsdg render` also
renders, to FOLDER (_out/depth_of_field).
"""

import argparse
from pathlib import Path

import numpy as np
from PIL import Image
from pxr import Sdf, Usd, UsdGeom, UsdLux, UsdShade

from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg.stage.poses.look_at import look_at_matrix
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.settings import PathSettings

FLOAT = Sdf.ValueTypeNames.Float
INPUTS = {"diffuseColor": Sdf.ValueTypeNames.Color3f, "metallic": FLOAT, "roughness": FLOAT}
MATERIALS = [((1.0, 0.7, 0.3), 1.0, 0.15), ((0.05, 0.2, 0.35), 0.0, 0.8), ((0.6, 0.05, 0.05), 0.0, 0.05)]

parser = argparse.ArgumentParser()
parser.add_argument("--out", type=Path, default="_out/depth_of_field")
parser.add_argument("--width", type=int, default=320)
parser.add_argument("--samples", type=int, default=64)
args = parser.parse_args()
size = args.width, args.width // 2
args.out.mkdir(parents=True, exist_ok=True)

# From the zenith to the horizon, with a bright window on one side, and dark ground below.
sky = np.linspace((70, 110, 190), (235, 225, 210), 64)[:, None].repeat(128, axis=1)
sky[8:28, 20:44], sky[36:] = 255, (60, 55, 50)
Image.fromarray(sky.astype(np.uint8)).save(args.out / "sky.png")

stage = Usd.Stage.CreateNew(str(args.out / "scene.usda"))
UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
UsdGeom.SetStageMetersPerUnit(stage, 1.0)
dome = UsdLux.DomeLight.Define(stage, "/World/Sky")
dome.CreateIntensityAttr(1200.0)
dome.CreateTextureFileAttr("sky.png")
UsdGeom.Plane.Define(stage, "/World/Floor").AddScaleOp().Set((30.0, 30.0, 1.0))
for k in range(9):
    ball = UsdGeom.Sphere.Define(stage, f"/World/Ball_{k}")
    ball.CreateRadiusAttr(0.5)
    ball.AddTranslateOp().Set((0.9 * (k - 4), 1.3 * (k - 4), 0.5))
    material = UsdShade.Material.Define(stage, f"/World/Ball_{k}/Look")
    shader = UsdShade.Shader.Define(stage, f"/World/Ball_{k}/Look/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    for (name, kind), value in zip(INPUTS.items(), MATERIALS[k % 3], strict=True):
        shader.CreateInput(name, kind).Set(value)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    UsdShade.MaterialBindingAPI.Apply(ball.GetPrim()).Bind(material)
camera = UsdGeom.Camera.Define(stage, "/World/Camera")
camera.AddTransformOp().Set(look_at_matrix((0, -6, 0.5), (0, 0, 0.5)))
camera.CreateClippingRangeAttr((0.1, 1000.0))
camera.CreateFocalLengthAttr(35.0)

renderer = WarpRenderer(stage)
renderer.sync()
labels = renderer.labels(read_camera(stage, "/World/Camera", size), ["distance_to_image_plane"])
camera.CreateFocusDistanceAttr(float(labels["distance_to_image_plane"][size[1] // 2, size[0] // 2]))
camera.CreateFStopAttr(8.0)
stage.Save()

film = renderer.new_film(*size)
view = read_camera(stage, "/World/Camera", size)
renderer.accumulate(film, view, samples=args.samples, settings=PathSettings(denoise=True))
Image.fromarray(renderer.develop(film)["LdrColor"][..., :3]).save(args.out / "picture.png", optimize=True)
print(f"sharp at {camera.GetFocusDistanceAttr().Get():.2f} m: {args.out / 'picture.png'}")
