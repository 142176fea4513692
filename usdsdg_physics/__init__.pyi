"""Types of the public names, which `__init__.py` loads when they are first used."""

from usdsdg_physics.engine import NewtonEngine as NewtonEngine
from usdsdg_physics.queries.scene_queries import Overlap as Overlap
from usdsdg_physics.queries.scene_queries import RayHit as RayHit
from usdsdg_physics.simulation import precompile as precompile
from usdsdg_physics.simulation import simulate as simulate
