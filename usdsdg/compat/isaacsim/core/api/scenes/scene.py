"""`Scene`: the objects of a world, by name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeVar

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg import demo
from usdsdg.compat import used_stage
from usdsdg.compat.isaacsim.core.api.materials import PhysicsMaterial
from usdsdg.compat.isaacsim.core.api.objects import GroundPlane
from usdsdg.compat.isaacsim.core.api.objects.shape import PHYSICS_MATERIALS, free_path
from usdsdg.compat.isaacsim.core.api.sensors.base_sensor import BaseSensor
from usdsdg.compat.isaacsim.core.utils.stage import add_reference_to_stage, remove_prim
from usdsdg.compat.wrappers import bounds
from usdsdg.demo.asset_urls import GRID_STAGE
from usdsdg.errors import AssetError, warn_once
from usdsdg.session import stage_context
from usdsdg.stage import assets


class Member(Protocol):
    """What a scene holds: wrappers of one prim or several."""

    @property
    def name(self) -> str: ...

    def is_valid(self) -> bool: ...

    def initialize(self, physics_sim_view: object = None) -> None: ...

    def post_reset(self) -> None: ...


Kind = TypeVar("Kind", bound=Member)


class Scene:
    """Objects that a world resets, in the order in which they were added."""

    def __init__(self) -> None:
        self._members: dict[str, Member] = {}
        self._bbox_cache: UsdGeom.BBoxCache | None = None

    @property
    def stage(self) -> Usd.Stage:
        return used_stage.current_stage()

    def add(self, obj: Kind) -> Kind:
        """Add a wrapper of prims; return it.

        Raises:
            TypeError: it is no such wrapper.
            ValueError: there is an object of its name.
        """
        if not all(hasattr(obj, each) for each in ("name", "post_reset", "is_valid")):
            raise TypeError(f"a scene cannot hold a {type(obj).__name__}; add wrappers of isaacsim.core")
        if obj.name in self._members:
            raise ValueError(f"the scene has an object named {obj.name!r} already; give another name")
        self._members[obj.name] = obj
        return obj

    def add_ground_plane(
        self,
        size: float | None = None,
        z_position: float = 0,
        name: str = "ground_plane",
        prim_path: str = "/World/groundPlane",
        static_friction: float = 0.5,
        dynamic_friction: float = 0.5,
        restitution: float = 0.8,
        color: Sequence[float] | np.ndarray | None = None,
    ) -> Member:
        """Add a gray ground plane; return the object of this name if there is one."""
        if self.object_exists(name):
            return self._members[name]
        material = _friction(static_friction, dynamic_friction, restitution)
        return self.add(GroundPlane(prim_path, name, size, z_position, color=color, physics_material=material))

    def add_default_ground_plane(
        self,
        z_position: float = 0,
        name: str = "default_ground_plane",
        prim_path: str = "/World/defaultGroundPlane",
        static_friction: float = 0.5,
        dynamic_friction: float = 0.5,
        restitution: float = 0.8,
    ) -> Member:
        """Add the grid environment of the assets root; return the object of this name if there is one.

        Where the root has none, that of the demo assets stands in for it, with a warning.

        Raises:
            AssetNotFound: the assets root does not exist.
        """
        if self.object_exists(name):
            return self._members[name]
        add_reference_to_stage(_grid_environment(), prim_path)
        material = _friction(static_friction, dynamic_friction, restitution)
        return self.add(GroundPlane(prim_path, name, z_position=z_position, physics_material=material))

    # --- by name ---
    def object_exists(self, name: str) -> bool:
        return name in self._members

    def get_object(self, name: str) -> Member | None:
        """Return the object of a name, or None."""
        return self._members.get(name)

    def remove_object(self, name: str, registry_only: bool = False) -> None:
        """Forget an object, and unless `registry_only` remove its prims."""
        member = self._members.pop(name)
        if not registry_only:
            for prim in _prims(member):
                remove_prim(prim)

    def clear(self, registry_only: bool = False) -> None:
        """Forget all objects, and unless `registry_only` remove their prims."""
        for name in list(self._members):
            self.remove_object(name, registry_only)

    def initialize(self) -> None:
        """Initialize sensors, and objects of classes that scripts define; others have nothing to prepare."""
        for member in list(self._members.values()):
            is_own = not type(member).initialize.__module__.startswith("usdsdg.")
            if member.is_valid() and (is_own or isinstance(member, BaseSensor)):
                member.initialize(None)

    def post_reset(self) -> None:
        """Give all objects their default poses and velocities; those without prims are forgotten."""
        for name, member in list(self._members.items()):
            if member.is_valid():
                member.post_reset()
            else:
                del self._members[name]

    # --- bounds ---
    def enable_bounding_boxes_computations(self) -> None:
        self._bbox_cache = bounds.bbox_cache(Usd.TimeCode.Default(), True)

    def disable_bounding_boxes_computations(self) -> None:
        self._bbox_cache = None

    def compute_object_AABB(self, name: str) -> np.ndarray:
        """Return the box (2, 3) along the axes of the world [stage units]: minimum, then maximum.

        Raises:
            RuntimeError: `enable_bounding_boxes_computations` has not been called.
        """
        if self._bbox_cache is None:
            raise RuntimeError("compute_object_AABB: call enable_bounding_boxes_computations first")
        self._bbox_cache.Clear()
        return bounds.aligned(self._bbox_cache, _prims(self._members[name])).reshape(2, 3)


def _grid_environment() -> str:
    """Return the file of the default ground."""
    stage_context.assets_root()  # which may be missing
    try:
        return assets.locate(GRID_STAGE)
    except AssetError as error:
        warn_once(f"the grid environment of the demo assets stands in for that of Isaac Sim: {error}")
        return demo.grid_environment()


def _friction(static: float, dynamic: float, restitution: float) -> PhysicsMaterial:
    path = free_path(PHYSICS_MATERIALS)
    return PhysicsMaterial(path, static_friction=static, dynamic_friction=dynamic, restitution=restitution)


def _prims(member: Member) -> list[Usd.Prim]:
    prims: list[Usd.Prim] = getattr(member, "prims", None) or [getattr(member, "prim")]  # noqa: B009 - not in the Protocol
    return [prim for prim in prims if prim.IsValid()]
