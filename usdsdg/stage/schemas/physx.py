"""The classes of NVIDIA's PhysxSchema, importable in place of `pxr.PhysxSchema`."""

from usdsdg.stage.schemas import RESOURCES, register
from usdsdg.stage.schemas.codeless import Schema, make_classes

register()

_classes = make_classes(RESOURCES / "physx", __name__)
globals().update(_classes)

__all__ = sorted(_classes)  # pyright: ignore[reportUnsupportedDunderAll]


# Types of prims that are simulated and have no class here.
_TYPES = {
    "PhysxPhysicsGearJoint": "physics:hinge0, physics:hinge1 and physics:gearRatio",
    "PhysxPhysicsRackAndPinionJoint": "physics:hinge, physics:prismatic and physics:ratio",
}


def __getattr__(name: str) -> type[Schema]:
    # An AttributeError, as `hasattr` expects of a module.
    if name in _TYPES:
        raise AttributeError(
            f"usdsdg's PhysxSchema has no class {name!r}; such joints are simulated: make one with "
            f"stage.DefinePrim(path, {name!r}) and set its {_TYPES[name]}"
        )
    raise AttributeError(
        f"usdsdg's PhysxSchema has no {name!r}: it covers rigid bodies, colliders, joints and triggers "
        f"({', '.join(__all__)}), not vehicles, particles or deformables"
    )
