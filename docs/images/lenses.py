"""The same place through a pinhole, an f-theta lens of 200 degrees, and as a panorama."""

import math
import os

import numpy as np
from PIL import Image

import usdsdg as rep
from docs import shapes_around

HEIGHT, SAMPLES = int(os.environ.get("WIDTH", 1176)) * 9 // 47, int(os.environ.get("SAMPLES", 64))
GAP = 8
rep.set_global_seed(3)
rep.settings.set_render_pathtraced(SAMPLES)
# A step of 2.4 radians, the golden angle, spreads the kinds of shapes.
shapes_around.add([(2.4 * k, 3.2 + 0.24 * k) for k in range(26)], height=0.5, colors=5)

EYE = {"position": (0, 0, 1.6), "clipping_range": (0.01, 100)}
# The angle from the axis is `fisheye_polynomial_b` times the distance from the center, in pixels of the nominal size.
fisheye = {
    "fisheye_nominal_width": 1600, "fisheye_nominal_height": 1000, "fisheye_optical_centre_x": 800,
    "fisheye_optical_centre_y": 500, "fisheye_polynomial_b": math.radians(100) / 600, "fisheye_max_fov": 200,
}  # fmt: skip
views = [
    rep.create.render_product(rep.create.camera(**EYE, **lens), (HEIGHT * wide // tall, HEIGHT))
    for lens, wide, tall in (
        ({"focal_length": 14}, 8, 5),
        ({"projection_type": "fisheyePolynomial", **fisheye}, 8, 5),
        ({"projection_type": "fisheyeSpherical"}, 2, 1),
    )
]
pictures = [rep.annotators.get("rgb").attach(view) for view in views]
rep.orchestrator.step()
gap = np.full((HEIGHT, GAP, 3), 255, np.uint8)
first, second, third = (picture.get_data()[..., :3] for picture in pictures)
Image.fromarray(np.hstack([first, gap, second, gap, third])).save("lenses.png", optimize=True)
