"""Simulate the rigid bodies of a USD stage with Newton, and write poses and velocities back to the prims."""

from usdsdg_physics.engine import NewtonEngine as NewtonEngine
from usdsdg_physics.queries.scene_queries import Overlap as Overlap
from usdsdg_physics.queries.scene_queries import RayHit as RayHit
from usdsdg_physics.simulation import precompile as precompile
from usdsdg_physics.simulation import simulate as simulate
