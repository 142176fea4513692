# %% setting
from pxr import UsdPhysics

import usdsdg as rep

floor = rep.create.plane(scale=10)
boxes = rep.create.cube(count=3, position=[(0, 0, 1), (0.2, 0, 2.1), (0, 0.2, 3.2)], scale=0.5)

# %% collider
rep.physics.collider(approximation_shape="none", input_prims=floor)  # the mesh itself; does not move

# %% rigid_body
rep.physics.rigid_body(input_prims=boxes)
with rep.trigger.on_custom_event("toss"), boxes:
    rep.physics.rigid_body(velocity=rep.distribution.uniform((-1, -1, 2), (1, 1, 4)))

# %% mass
with boxes:
    rep.physics.mass(density=rep.distribution.uniform(200, 800))  # kg per cubic meter

# %% physics_material
with boxes:
    rep.physics.physics_material(static_friction=0.6, dynamic_friction=0.5, restitution=0.1)

# %% simulate
rep.physics.simulate(0.5)  # half a second, now; under a trigger, at each firing

# %% simulate_until_rest
moving = rep.physics.simulate_until_rest(max_time=5.0)
assert moving == []

# %% reset
rep.physics.reset()

# %% drive_properties
stage = boxes.get_output_prims()["prims"][0].GetStage()
hinge = UsdPhysics.RevoluteJoint.Define(stage, "/World/Hinge")
with rep.trigger.on_frame(), rep.get.prim_at_path("/World/Hinge"):
    rep.physics.drive_properties(stiffness=100.0, damping=rep.distribution.uniform(1.0, 5.0))
