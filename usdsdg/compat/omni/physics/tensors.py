"""`omni.physics.tensors`: the types of joints. Its views are not available; use the wrappers of `isaacsim.core`."""

from __future__ import annotations

from enum import IntEnum

from usdsdg.compat.wrappers.unsupported import refused_function


class DofType(IntEnum):
    """What a joint with a position does."""

    Rotation = 0
    Translation = 1
    Invalid = 255


class JointType(IntEnum):
    """What a joint is."""

    Fixed = 0
    Revolute = 1
    Prismatic = 2
    Spherical = 3
    Invalid = 255


create_simulation_view = refused_function(
    "omni.physics.tensors.create_simulation_view",
    "there are no tensor views; use Articulation and RigidPrim of isaacsim.core.prims, which take and return arrays",
)
