# %% setting
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

import usdsdg as rep

Path("parts").mkdir(exist_ok=True)
trimesh.creation.icosphere(radius=0.1).export("parts/ball.obj")
Image.fromarray(np.full((8, 8, 3), 90, np.uint8)).save("label.png")

# %% cube, sphere, cone, cylinder, disk, plane
rep.create.plane(scale=10)
rep.create.cube(position=(0, 0, 0.5), semantics=[("class", "box")])
rep.create.sphere(position=[(2, 0, 0.5), (3, 0, 0.5)], scale=0.5, count=2)
with rep.trigger.on_frame():
    # A distribution is drawn again at every firing.
    rep.create.cone(position=rep.distribution.uniform((-2, -2, 0), (2, 2, 0)))
can = rep.create.cylinder(scale=(0.3, 0.3, 0.5), rotation=(90, 0, 0))
lid = rep.create.disk(scale=0.3, parent=can)

# %% torus
ring = rep.create.torus(scale=(1, 1, 0.5), semantics=[("class", "ring")])

# %% from_usd
ball = rep.create.from_usd("parts/ball.obj", position=(0, 0, 1), count=2)  # the class is "ball"

# %% from_dir
parts = rep.create.from_dir("parts", path_filter=r"\.obj$")

# %% xform
pivot = rep.create.xform(position=(0, 0, 1))
rep.create.cube(scale=0.1, position=(0.5, 0, 0), parent=pivot)

# %% group
both = rep.create.group([ball, ring], semantics=[("material", "steel")])
with rep.trigger.on_frame(), both:
    rep.randomizer.rotation()

# %% light
rep.create.light(light_type="Dome", intensity=300)
rep.create.light(light_type="Distant", intensity=2000, rotation=(40, 20, 0))
lamps = rep.create.light(
    light_type="Sphere",
    count=3,
    scale=0.2,
    intensity=rep.distribution.uniform(10_000, 50_000),
    position=rep.distribution.uniform((-2, -2, 2), (2, 2, 3)),
    temperature=rep.distribution.normal(4500, 500),
)

# %% camera
camera = rep.create.camera(position=(4, 0, 2), look_at=(0, 0, 0), focal_length=35, clipping_range=(0.1, 100))
fisheye = rep.create.camera(projection_type="fisheyeEquidistant", position=(0, 0, 3), clipping_range=(0.1, 100))

# %% stereo_camera
pair = rep.create.stereo_camera(stereo_baseline=0.12, position=(4, 0, 2), look_at=(0, 0, 0))

# %% camera_rig
Path("rig.yaml").write_text("""
cam0:
  camera_model: pinhole
  intrinsics: [400.0, 400.0, 320.0, 240.0]
  distortion_model: radtan
  distortion_coeffs: [-0.2, 0.05, 0.0, 0.0]
  resolution: [640, 480]
cam1:
  camera_model: pinhole
  intrinsics: [400.0, 400.0, 320.0, 240.0]
  distortion_model: radtan
  distortion_coeffs: [-0.2, 0.05, 0.0, 0.0]
  resolution: [640, 480]
  T_cn_cnm1: [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
""")
rig = rep.create.camera_rig("rig.yaml", position=(4, 0, 2), look_at=(0, 0, 0))  # a camchain of Kalibr
left, right = rig.get_output_prims()["prims"][0].GetChildren()

# %% render_product
view = rep.create.render_product(camera, (640, 480))

# %% render_product_tiled
tiles = rep.create.render_product_tiled([camera, fisheye], tile_resolution=(64, 48))

# %% tiled_sensor
sensor = rep.create.tiled_sensor([camera, fisheye], camera_resolution=(64, 48), tiled_resolution=(128, 48))

# %% material_omnipbr
steel = rep.create.material_omnipbr(diffuse=(0.6, 0.6, 0.6), metallic=1.0, roughness=rep.distribution.uniform(0.2, 0.6))
rep.create.cube(material=steel)

# %% projection_material
projector = rep.create.cube(position=(0, 0, 2), rotation=(0, -90, 0), scale=0.5, visible=False)  # its -X points down
with can:
    label = rep.create.projection_material(projector, semantics=[("class", "label")], material=steel)

# %% mesh_decal
with can:
    rep.create.mesh_decal(diffuse="label.png", position=(0, 0, 1), scale=(0.2, 0.2, 2))


# %% register
def create_pile(count):
    return rep.create.cube(count=count, scale=0.1)


rep.create.register(create_pile, fn_name="pile")
rep.create.pile(count=3)

# %% mdl_from_json
try:
    rep.create.mdl_from_json({})
except rep.errors.Unsupported as error:
    print(error)  # names what does the same here
