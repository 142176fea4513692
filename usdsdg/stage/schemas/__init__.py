"""Codeless schemas that usd-core does not include: PhysxSchema, the labels of older Replicator
versions, sensors, and behaviors.

Each folder under `resources` holds a plugInfo.json and a generatedSchema.usda. The Python classes are generated from
these, so that a schema, its defaults and its methods are defined once.
"""

import os
from pathlib import Path

from pxr import Plug, Usd

from usdsdg.errors import StageError

RESOURCES = Path(__file__).parent / "resources"


def register() -> None:
    """Register the schemas with USD, before the process uses its first stage or prim definition.

    Raises:
        StageError: USD's schema registry, which is built once, exists already.
    """
    folders = [str(folder) for folder in sorted(RESOURCES.iterdir())]
    Plug.Registry().RegisterPlugins(folders)
    if not Usd.SchemaRegistry().FindAppliedAPIPrimDefinition("PhysxRigidBodyAPI"):
        raise StageError(
            "PhysxSchema could not be added, because this process had made a USD stage before usdsdg was "
            "imported. Import usdsdg before the first use of pxr.Usd."
        )
    _clear_environment(folders)


def _clear_environment(folders: list[str]) -> None:
    """Take out of the environment what `import usdsdg` put there, so that programs started from here do not see it."""
    paths = os.environ.get("PXR_PLUGINPATH_NAME", "").split(os.pathsep)
    others = [path for path in paths if path.rstrip("/") not in folders]
    if len(others) < len(paths):
        os.environ["PXR_PLUGINPATH_NAME"] = os.pathsep.join(others)
        if not others:
            del os.environ["PXR_PLUGINPATH_NAME"]
