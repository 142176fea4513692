"""`omni.behavior.scripting.core`: Python scripts that are attached to prims. `omni.kit.scripting` is its older name."""

from usdsdg.compat.omni.behavior.scripting.behavior_script import BehaviorScript
from usdsdg.compat.omni.behavior.scripting.script_manager import ScriptManager, get_script_manager

__all__ = ["BehaviorScript", "ScriptManager", "get_script_manager"]

get_script_manager()
