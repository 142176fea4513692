"""A bottle that moves while it is exposed: noisy, after the wavelet filter, and after Open Image Denoise."""

import os

import numpy as np
from PIL import Image
from pxr import Gf, Usd, UsdGeom, UsdLux

from usdsdg import demo
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.settings import PathSettings, ToneSettings

WIDTH, SAMPLES = int(os.environ.get("WIDTH", 946)) // 3, int(os.environ.get("SAMPLES", 8))
GAP = 8
MOVED = 0.03  # meters while the shutter is open

stage = Usd.Stage.CreateInMemory()
UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
UsdGeom.SetStageMetersPerUnit(stage, 1.0)
sky = UsdLux.DomeLight.Define(stage, "/World/Sky")
sky.CreateTextureFileAttr(f"{demo.root()}/NVIDIA/Assets/Skies/Indoor/wooden_lounge_4k.hdr")
sky.CreateIntensityAttr(1100)
bottle = UsdGeom.Xform.Define(stage, "/World/Bottle")
bottle.GetPrim().GetReferences().AddReference(f"{demo.root()}/Isaac/Props/YCB/Axis_Aligned/006_mustard_bottle.usd")
place = bottle.AddTranslateOp(opSuffix="moved")
camera = UsdGeom.Camera.Define(stage, "/World/Camera")
camera.CreateFocalLengthAttr(35)
camera.CreateClippingRangeAttr((0.01, 100))
camera.AddTranslateOp().Set(Gf.Vec3d(0.0, -0.35, 0.04))
camera.AddRotateXYZOp().Set(Gf.Vec3f(90, 0, 0))

renderer = WarpRenderer(stage)
renderer.sync()
place.Set(Gf.Vec3d(MOVED, 0, 0))
renderer.sync()
view = read_camera(stage, "/World/Camera", (WIDTH, WIDTH * 2 // 3))
film = renderer.new_film(view.width, view.height)
for sample in range(SAMPLES):
    renderer.place_between((sample + 0.5) / SAMPLES)
    settings = PathSettings(seed=1, first_sample=sample, denoise=True)
    renderer.accumulate(film, view, samples=1, settings=settings)
gap = np.full((view.height, GAP, 3), 255, np.uint8)
tones = (ToneSettings(denoise=False), ToneSettings(denoiser="wavelet"), ToneSettings(denoiser="oidn"))
noisy, wavelet, oidn = (renderer.develop(film, tone)["LdrColor"][..., :3] for tone in tones)
Image.fromarray(np.hstack([noisy, gap, wavelet, gap, oidn])).save("noise.png", optimize=True)
