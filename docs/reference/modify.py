# %% setting
from pxr import UsdSkel

import usdsdg as rep

rep.create.light(light_type="Dome")
boxes = rep.create.cube(count=3, semantics=[("class", "box")])
camera = rep.create.camera(position=(4, 0, 2), look_at=(0, 0, 0))
view = rep.create.render_product(camera, (64, 48))

# %% pose
with rep.trigger.on_frame(), boxes:
    rep.modify.pose(
        position=rep.distribution.uniform((-1, -1, 0), (1, 1, 1)),
        rotation=rep.distribution.uniform((0, 0, -180), (0, 0, 180)),
        scale=rep.distribution.uniform(0.5, 1.0),
    )

# %% pose_orbit
with rep.trigger.on_frame(), camera:
    rep.modify.pose_orbit(
        barycentre=(0, 0, 0),
        distance=rep.distribution.uniform(3, 5),
        azimuth=rep.distribution.uniform(0, 360),
        elevation=rep.distribution.uniform(10, 60),
    )

# %% pose_camera_relative
with rep.trigger.on_frame(), boxes:
    rep.modify.pose_camera_relative(camera, view, distance=4, horizontal_location=rep.distribution.uniform(-0.8, 0.8))

# %% attribute
with rep.trigger.on_frame(), camera:
    rep.modify.attribute("focalLength", rep.distribution.uniform(18, 50))

# %% semantics
with boxes:
    rep.modify.semantics([("color", "gray")])
    rep.modify.semantics({"class": "crate"}, mode="replace")

# %% visibility
with rep.trigger.on_frame(), boxes:
    rep.modify.visibility(rep.distribution.choice([True, False], weights=[3, 1]))

# %% material
red = rep.create.material_omnipbr(diffuse=(0.6, 0.05, 0.05))
blue = rep.create.material_omnipbr(diffuse=(0.05, 0.1, 0.6))
with rep.trigger.on_frame(), boxes:
    rep.modify.material(rep.distribution.choice([red, blue]))

# %% variant
prim = boxes.get_output_prims()["prims"][0]
sizes = prim.GetVariantSets().AddVariantSet("size")
for name in ("small", "large"):
    sizes.AddVariant(name)
with rep.trigger.on_frame(), rep.get.prim_at_path(str(prim.GetPath())):
    rep.modify.variant("size", rep.distribution.choice(["small", "large"]))

# %% projection_material
projector = rep.create.cube(position=(0, 0, 2), rotation=(0, -90, 0), visible=False)  # its -X points down
with boxes:
    sticker = rep.create.projection_material(projector)
with rep.trigger.on_frame(), sticker:
    rep.modify.projection_material(position=rep.distribution.uniform((-0.2, -0.2, 2), (0.2, 0.2, 2)))

# %% time, frame, timeline
rep.modify.time(0.5)  # seconds
rep.modify.frame(12)  # time codes
rep.modify.timeline(2.0, "end_time")

# %% animation
stage = boxes.get_output_prims()["prims"][0].GetStage()
UsdSkel.Skeleton.Define(stage, "/World/Skeleton")
UsdSkel.Animation.Define(stage, "/World/Walk")
with rep.trigger.on_frame(), rep.get.prim_at_path("/World/Skeleton"):
    rep.modify.animation(["/World/Walk"])


# %% register
def spin(degrees):
    return rep.modify.pose(rotation=rep.distribution.uniform((0, 0, -degrees), (0, 0, degrees)))


rep.modify.register(spin)
with rep.trigger.on_frame(), boxes:
    rep.modify.spin(45)
