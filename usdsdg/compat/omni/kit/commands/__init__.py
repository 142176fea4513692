"""`omni.kit.commands`: commands by name, those that scripts use beside Replicator, and a script's own."""

from usdsdg.compat.omni.kit.commands import (
    composition,
    materials,
    physics,
    playing,
    prims,
    properties,
    scripting,
    sensors,
    transforms,
)
from usdsdg.compat.omni.kit.commands.registry import (
    Command,
    create,
    execute,
    get_command_class,
    get_commands,
    get_commands_list,
    register,
    register_all_commands_in_module,
    unregister,
)

__all__ = [
    "Command", "composition", "create", "execute", "get_command_class", "get_commands", "get_commands_list",
    "materials", "physics", "playing", "prims", "properties", "register", "register_all_commands_in_module",
    "scripting", "sensors", "transforms", "unregister",
]  # fmt: skip
