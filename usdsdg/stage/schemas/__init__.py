"""Schemas that usd-core does not ship, without C++: PhysxSchema and the labels of older Replicator versions.

Each folder under `resources` holds a plugInfo.json and a generatedSchema.usda; the Python classes are made
from these two, so that a schema, its defaults and its methods are written down once.
"""

from pathlib import Path

from pxr import Plug, Usd

from usdsdg.errors import StageError

RESOURCES = Path(__file__).parent / "resources"


def register() -> None:
    """Tell USD about the schemas; has to come before the process touches its first stage or prim definition.

    Raises:
        StageError: USD's schema registry had been built already, and it never looks again.
    """
    Plug.Registry().RegisterPlugins([str(folder) for folder in sorted(RESOURCES.iterdir())])
    if not Usd.SchemaRegistry().FindAppliedAPIPrimDefinition("PhysxRigidBodyAPI"):
        raise StageError(
            "PhysxSchema could not be added, because this process had made a USD stage before usdsdg was "
            "imported. Import usdsdg.stage (or usdsdg.compat) before the first use of pxr.Usd."
        )
