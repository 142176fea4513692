"""`omni.isaac.core.articulations`: wrappers of robots under their older names: that of several ends in "View"."""

from usdsdg.compat.isaacsim.core.api.articulations import ArticulationGripper, ArticulationSubset
from usdsdg.compat.isaacsim.core.prims import Articulation as ArticulationView
from usdsdg.compat.isaacsim.core.prims import SingleArticulation as Articulation

__all__ = ["Articulation", "ArticulationGripper", "ArticulationSubset", "ArticulationView"]
