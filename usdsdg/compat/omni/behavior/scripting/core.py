"""`omni.behavior.scripting.core`: Python scripts that are attached to prims. `omni.kit.scripting` is its older name."""

from usdsdg.compat.omni.behavior.scripting.behavior_script import BehaviorScript
from usdsdg.compat.omni.behavior.scripting.script_manager import ScriptManager, get_script_manager
from usdsdg.compat.omni.kit.commands.command_classes import class_of

__all__ = [
    "ApplyScriptingAPICommand", "BehaviorScript", "RemoveScriptingAPICommand", "ScriptManager", "get_script_manager"
]  # fmt: skip

ApplyScriptingAPICommand = class_of("ApplyScriptingAPICommand")
RemoveScriptingAPICommand = class_of("RemoveScriptingAPICommand")

get_script_manager()
