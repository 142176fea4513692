"""Author UsdPhysics schemas, fixed or randomized, and simulate without a timeline. Mirrors `rep.physics`."""

from usdsdg.arguments.parameters import name_parameters
from usdsdg.physics.joint_drives import drive_properties
from usdsdg.physics.mass_properties import mass
from usdsdg.physics.materials import physics_material
from usdsdg.physics.rigid_bodies import collider, rigid_body
from usdsdg.physics.simulation import reset, simulate, simulate_until_rest

__all__ = [
    "collider", "drive_properties", "mass", "physics_material", "reset", "rigid_body", "simulate",
    "simulate_until_rest",
]  # fmt: skip

name_parameters(globals())
