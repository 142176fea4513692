"""The classes of NVIDIA's PhysxSchema, importable in place of `pxr.PhysxSchema`."""

from usdsdg.stage.schemas import RESOURCES, register
from usdsdg.stage.schemas.codeless import Schema, make_classes

register()

_classes = make_classes(RESOURCES / "physx", __name__)
globals().update(_classes)

__all__ = sorted(_classes)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> type[Schema]:
    # An AttributeError, as `hasattr` expects of a module.
    raise AttributeError(
        f"usdsdg's PhysxSchema has no {name!r}: it covers rigid bodies, colliders, joints and triggers "
        f"({', '.join(__all__)}), not vehicles, particles or deformables"
    )
