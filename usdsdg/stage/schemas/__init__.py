"""Codeless schemas that usd-core does not include: PhysxSchema, and the labels of older Replicator versions.

Each folder under `resources` holds a plugInfo.json and a generatedSchema.usda. The Python classes are generated from
these, so that a schema, its defaults and its methods are defined once.
"""

from pathlib import Path

from pxr import Plug, Usd

from usdsdg.errors import StageError

RESOURCES = Path(__file__).parent / "resources"


def register() -> None:
    """Register the schemas with USD, before the process uses its first stage or prim definition.

    Raises:
        StageError: USD's schema registry, which is built once, exists already.
    """
    Plug.Registry().RegisterPlugins([str(folder) for folder in sorted(RESOURCES.iterdir())])
    if not Usd.SchemaRegistry().FindAppliedAPIPrimDefinition("PhysxRigidBodyAPI"):
        raise StageError(
            "PhysxSchema could not be added, because this process had made a USD stage before usdsdg was "
            "imported. Import usdsdg.stage (or usdsdg.compat) before the first use of pxr.Usd."
        )
