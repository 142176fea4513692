# %% setting

import numpy as np
import trimesh
from PIL import Image

import usdsdg as rep

table = rep.create.plane(scale=4)
boxes = rep.create.cube(count=5, scale=0.3)
for name, shade in (("dark", 40), ("bright", 220)):
    Image.fromarray(np.full((8, 8, 3), shade, np.uint8)).save(f"{name}.png")
    trimesh.creation.box((0.1, 0.1, 0.1)).export(f"{name}.obj")

# %% scatter_2d
with rep.trigger.on_frame(), boxes:
    rep.randomizer.scatter_2d(table, check_for_collisions=True)

# %% scatter_3d
with rep.trigger.on_frame(), boxes:
    rep.randomizer.scatter_3d(min_samp=(-1, -1, 0.5), max_samp=(1, 1, 2), check_for_collisions=True)

# %% rotation
with rep.trigger.on_frame(), boxes:
    rep.randomizer.rotation()  # any orientation, uniformly
    rep.randomizer.rotation((-10, -10, 0), (10, 10, 360))  # about upright

# %% color
with rep.trigger.on_frame(), boxes:
    rep.randomizer.color(colors=rep.distribution.uniform((0, 0, 0), (1, 1, 1)))

# %% texture
with rep.trigger.on_frame(), boxes:
    rep.randomizer.texture(["dark.png", "bright.png"], texture_scale=(2, 2))

# %% materials
steel = rep.create.material_omnipbr(metallic=1.0, roughness=0.3)
paint = rep.create.material_omnipbr(diffuse=(0.7, 0.2, 0.1))
with rep.trigger.on_frame(), boxes:
    rep.randomizer.materials([steel, paint])

# %% instantiate
with rep.trigger.on_frame():
    parts = rep.randomizer.instantiate(["dark.obj", "bright.obj"], size=4, weights=[1, 3])
    with parts:
        rep.modify.pose(position=rep.distribution.uniform((-1, -1, 0), (1, 1, 1)))


# %% register
def clutter(count):
    shapes = rep.create.sphere(count=count, scale=0.1)
    with shapes:
        rep.modify.pose(position=rep.distribution.uniform((-2, -2, 0), (2, 2, 1)))
    return shapes.node


rep.randomizer.register(clutter)
with rep.trigger.on_frame():
    rep.randomizer.clutter(6)
