"""`isaacsim.core.api.articulations`: some joints of a robot, and its gripper."""

from usdsdg.compat.isaacsim.core.api.articulations.articulation_gripper import ArticulationGripper
from usdsdg.compat.isaacsim.core.api.articulations.articulation_subset import ArticulationSubset

__all__ = ["ArticulationGripper", "ArticulationSubset"]
