"""`isaacsim.core.api.controllers`: what turns the commands of a script into targets of joints."""

from usdsdg.compat.isaacsim.core.api.controllers.articulation_controller import ArticulationController
from usdsdg.compat.isaacsim.core.api.controllers.base_controller import BaseController
from usdsdg.compat.isaacsim.core.api.controllers.base_gripper_controller import BaseGripperController

__all__ = ["ArticulationController", "BaseController", "BaseGripperController"]
