"""The panorama of the left eye over that of the right one, which are far apart here: 40 cm."""

import math
import os

import numpy as np
from PIL import Image
from pxr import Sdf

import usdsdg as rep
from docs import shapes_around

WIDTH, SAMPLES = int(os.environ.get("WIDTH", 800)), int(os.environ.get("SAMPLES", 64))
GAP = 8
rep.set_global_seed(3)
rep.settings.set_render_pathtraced(SAMPLES)
shapes_around.add([(math.radians(30 * k + 15), (2.0, 3.0, 4.5)[k % 3]) for k in range(12)], height=0.6, colors=3)

pictures = []
for left in (True, False):
    item = rep.create.camera(position=(0, 0, 1.6), projection_type="omniDirectionalStereo", clipping_range=(0.01, 100))
    camera = item.get_output_prims()["prims"][0].GetChild("Camera")
    camera.CreateAttribute("isLeftEye", Sdf.ValueTypeNames.Bool).Set(left)
    camera.CreateAttribute("interpupillaryDistance", Sdf.ValueTypeNames.Float).Set(40.0)  # centimeters
    view = rep.create.render_product(item, (WIDTH, WIDTH // 2))
    pictures.append(rep.annotators.get("rgb").attach(view))
rep.orchestrator.step()
# What is high above or deep below the eyes shows nothing but sky and floor.
seen = [picture.get_data()[WIDTH // 8 : WIDTH * 3 // 8, :, :3] for picture in pictures]
gap = np.full((GAP, WIDTH, 3), 255, np.uint8)
Image.fromarray(np.vstack([seen[0], gap, seen[1]])).save("stereo.png", optimize=True)
