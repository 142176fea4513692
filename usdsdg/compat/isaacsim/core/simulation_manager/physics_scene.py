"""`PhysicsScene` and `PhysxScene`: step length, gravity and settings of PhysX of a PhysicsScene prim."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any

from pxr import Gf, Sdf, Usd, UsdPhysics

from usdsdg.compat import used_stage
from usdsdg.compat.wrappers import prim_paths
from usdsdg.stage.physics.scenes import EARTH_GRAVITY, step_rate_attribute, steps_per_second
from usdsdg.stage.poses.transforms import meters_per_unit, up_vector
from usdsdg.stage.schemas import physx


@dataclass(kw_only=True)
class PhysxGpuCfg:
    """Sizes of PhysX's buffers on a GPU [bytes, or number of entries]; None leaves one as it is."""

    gpu_collision_stack_size: int | None = None
    gpu_found_lost_aggregate_pairs_capacity: int | None = None
    gpu_found_lost_pairs_capacity: int | None = None
    gpu_heap_capacity: int | None = None
    gpu_max_deformable_surface_contacts: int | None = None
    gpu_max_num_partitions: int | None = None
    gpu_max_particle_contacts: int | None = None
    gpu_max_rigid_contact_count: int | None = None
    gpu_max_rigid_patch_count: int | None = None
    gpu_max_soft_body_contacts: int | None = None
    gpu_temp_buffer_capacity: int | None = None
    gpu_total_aggregate_pairs_capacity: int | None = None


class PhysicsScene:
    """A PhysicsScene prim; it is defined if there is no prim."""

    def __init__(self, prim: str | Usd.Prim = "/PhysicsScene") -> None:
        """Wrap or define the scene.

        Raises:
            ValueError: the prim is no PhysicsScene.
        """
        found = prim_paths.prim_of(prim)
        if not found:
            found = UsdPhysics.Scene.Define(used_stage.current_stage(), Sdf.Path(str(prim))).GetPrim()
        if not found.IsA(UsdPhysics.Scene):
            raise ValueError(
                f"{found.GetPath()} is no PhysicsScene but a {found.GetTypeName() or 'prim without a type'}"
            )
        self._prim = found
        physx.PhysxSceneAPI.Apply(found)

    @property
    def path(self) -> str:
        return str(self._prim.GetPath())

    @property
    def prim(self) -> Usd.Prim:
        return self._prim

    @property
    def physics_scene(self) -> UsdPhysics.Scene:
        return UsdPhysics.Scene(self._prim)

    @staticmethod
    def get_physics_scene_paths(stage: Usd.Stage | None = None) -> list[str]:
        """Return the paths of all PhysicsScene prims."""
        prims = (stage or used_stage.current_stage()).Traverse()
        return [str(prim.GetPath()) for prim in prims if prim.IsA(UsdPhysics.Scene)]

    # --- steps ---
    def get_dt(self) -> float:
        """Return the length of a step [s]; 0 where the rate is 0."""
        rate = steps_per_second(self._prim)
        return 1.0 / rate if rate else 0.0

    def set_dt(self, dt: float) -> None:
        """Set the length of a step [s]. PhysX counts whole steps per second: 1/dt, rounded down.

        Raises:
            ValueError: `dt` is not within 0 and 1.
        """
        if not 0.0 <= dt <= 1.0:
            raise ValueError(f"a physics step of {dt} s is not within 0 and 1 s")
        # A rate such as 1 / (1 / 90) may come out just below the whole number.
        self.set_steps_per_second(int(1.0 / dt * (1.0 + 1e-9)) if dt else 0)

    def get_steps_per_second(self) -> int:
        return int(steps_per_second(self._prim))

    def set_steps_per_second(self, steps_per_second: int) -> None:
        """Set the number of steps per second of simulated time.

        Raises:
            ValueError: it is negative.
        """
        if steps_per_second < 0:
            raise ValueError(f"{steps_per_second} steps per second: give 0 or more")
        step_rate_attribute(self._prim).Set(int(steps_per_second))

    # --- gravity ---
    def get_gravity(self) -> Gf.Vec3f:
        """Return gravity [stage units/s²]; where none is authored, 9.81 m/s² downward."""
        stage, scene = self._prim.GetStage(), self.physics_scene
        direction, magnitude = Gf.Vec3f(scene.GetGravityDirectionAttr().Get()), scene.GetGravityMagnitudeAttr().Get()
        if direction.GetLength() == 0.0:
            direction = -Gf.Vec3f(*up_vector(stage))
        # The schema's fallback, -inf, means gravity of the earth.
        return direction * (magnitude if magnitude >= 0.0 else EARTH_GRAVITY / meters_per_unit(stage))

    def set_gravity(self, gravity: Sequence[float]) -> None:
        """Set gravity (3,) [stage units/s²]."""
        vector = Gf.Vec3f(*(float(component) for component in gravity))
        direction = vector.GetNormalized() if vector.GetLength() else -Gf.Vec3f(*up_vector(self._prim.GetStage()))
        self.physics_scene.CreateGravityMagnitudeAttr().Set(vector.GetLength())
        self.physics_scene.CreateGravityDirectionAttr().Set(direction)

    # --- settings of PhysX, which are kept on the stage ---
    def get(self, name: str) -> Any:
        """Return an attribute of PhysxSceneAPI, such as "BroadphaseType"."""
        return getattr(physx.PhysxSceneAPI(self._prim), f"Get{name}Attr")().Get()

    def set(self, name: str, value: Any) -> None:
        """Author an attribute of PhysxSceneAPI; Newton's solver has no counterpart of most of them."""
        getattr(physx.PhysxSceneAPI(self._prim), f"Create{name}Attr")().Set(value)

    def get_solver_type(self) -> str:
        return str(self.get("SolverType"))

    def set_solver_type(self, solver_type: str) -> None:
        self.set("SolverType", _one_of(solver_type, ("TGS", "PGS")))

    def get_broadphase_type(self) -> str:
        return str(self.get("BroadphaseType"))

    def set_broadphase_type(self, broadphase_type: str) -> None:
        self.set("BroadphaseType", _one_of(broadphase_type, ("MBP", "GPU", "SAP")))

    def get_enabled_ccd(self) -> bool:
        return bool(self.get("EnableCCD"))

    def set_enabled_ccd(self, enabled: bool) -> None:
        self.set("EnableCCD", bool(enabled))

    def get_enabled_gpu_dynamics(self) -> bool:
        return bool(self.get("EnableGPUDynamics"))

    def set_enabled_gpu_dynamics(self, enabled: bool) -> None:
        self.set("EnableGPUDynamics", bool(enabled))

    def get_enabled_stabilization(self) -> bool:
        return bool(self.get("EnableStabilization"))

    def set_enabled_stabilization(self, enabled: bool) -> None:
        self.set("EnableStabilization", bool(enabled))

    def get_gpu_configuration(self) -> PhysxGpuCfg:
        return PhysxGpuCfg(**{each.name: int(self.get(_attribute(each.name))) for each in fields(PhysxGpuCfg)})

    def set_gpu_configuration(self, cfg: PhysxGpuCfg | Mapping[str, int | None]) -> None:
        """Author the sizes that are given; Newton's solver sizes its buffers by what it simulates."""
        given = cfg if isinstance(cfg, PhysxGpuCfg) else PhysxGpuCfg(**cfg)
        for name, size in asdict(given).items():
            if size is not None:
                self.set(_attribute(name), int(size))


PhysxScene = PhysicsScene


def _attribute(name: str) -> str:
    """Return the name by which PhysxSceneAPI has an attribute: "GpuHeapCapacity" of "gpu_heap_capacity"."""
    return "".join(map(str.capitalize, name.split("_")))


def _one_of(value: str, allowed: tuple[str, ...]) -> str:
    if value not in allowed:
        raise ValueError(f"{value!r} is not one of {', '.join(allowed)}")
    return value
