"""Commands that let prims name Python files, their behaviors."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Sdf

from usdsdg.compat.omni.behavior.scripting.script_manager import SCRIPTS, get_script_manager
from usdsdg.compat.omni.kit.commands.registry import command
from usdsdg.compat.wrappers.prim_paths import existing_prim

SCHEMA = "OmniScriptingAPI"


@command("ApplyScriptingAPI")
def apply_scripting_api(paths: Sequence[str | Sdf.Path]) -> None:
    """Give prims the attribute that names their Python files, which start as soon as it has some.

    Raises:
        BadPrim: there is no prim at a path.
    """
    get_script_manager()
    for path in paths:
        prim = existing_prim(str(path))
        prim.AddAppliedSchema(SCHEMA)
        if not prim.HasAttribute(SCRIPTS):
            prim.CreateAttribute(SCRIPTS, Sdf.ValueTypeNames.AssetArray)


@command("RemoveScriptingAPI")
def remove_scripting_api(paths: Sequence[str | Sdf.Path]) -> None:
    """Take the attribute from prims, which ends what their files do.

    Raises:
        BadPrim: there is no prim at a path.
    """
    for path in paths:
        prim = existing_prim(str(path))
        prim.RemoveAppliedSchema(SCHEMA)
        prim.RemoveProperty(SCRIPTS)
