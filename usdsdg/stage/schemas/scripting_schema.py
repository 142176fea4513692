"""The schema of prims that name Python files, their behaviors, importable in place of `pxr.OmniScriptingSchema`."""

from usdsdg.stage.schemas import RESOURCES, register
from usdsdg.stage.schemas.codeless import make_classes

register()

OmniScriptingAPI = make_classes(RESOURCES / "scripting", __name__)["OmniScriptingAPI"]

__all__ = ["OmniScriptingAPI"]
