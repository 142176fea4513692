"""`isaacsim.core.api.robots`: one robot, and several."""

from usdsdg.compat.isaacsim.core.api.robots.robot import Robot
from usdsdg.compat.isaacsim.core.api.robots.robot_view import RobotView

__all__ = ["Robot", "RobotView"]
