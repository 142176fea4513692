"""`PhysicsContext`: the PhysicsScene of a world."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pxr import Gf, Usd, UsdPhysics, UsdShade

from usdsdg.compat import used_stage
from usdsdg.compat.isaacsim.core.simulation_manager import SimulationManager
from usdsdg.compat.isaacsim.core.simulation_manager.physics_scene import PhysicsScene
from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.errors import warn_once
from usdsdg.stage.physics.scenes import EARTH_GRAVITY, physics_scene
from usdsdg.stage.poses.transforms import meters_per_unit, up_axis

# Arguments of `sim_params` that are not attributes of a PhysicsScene; all others begin with "gpu_".
_PARAMETERS = {
    "bounce_threshold_velocity": "BounceThreshold",
    "friction_offset_threshold": "FrictionOffsetThreshold",
    "friction_correlation_distance": "FrictionCorrelationDistance",
    "enable_stabilization": "EnableStabilization",
    "enable_scene_query_support": "EnableSceneQuerySupport",
}
_KNOWN = {
    "dt", "gravity", "substeps", "solver_type", "default_physics_material", "use_gpu_pipeline", "use_gpu", "device",
    "use_fabric", "worker_thread_count", "disable_contact_processing",
}  # fmt: skip


class PhysicsContext:
    """Step length, gravity and settings of the PhysicsScene; that of the stage is taken if there is one."""

    def __init__(
        self,
        physics_dt: float | None = None,
        prim_path: str = "/physicsScene",
        sim_params: Mapping[str, Any] | None = None,
        set_defaults: bool = True,
    ) -> None:
        """Wrap or define the PhysicsScene.

        Args:
            physics_dt: length of a step [s].
            sim_params: "dt", "gravity" (3,), "solver_type", "default_physics_material", and PhysX's settings.
            set_defaults: Without `sim_params`, set gravity to 9.81 m/s² along -Z and the step to 1/60 s.
        """
        existing = physics_scene(used_stage.current_stage())
        self._scene = PhysicsScene(existing or prim_path)
        simulation().scene_path = self._scene.path
        if sim_params is None and set_defaults:
            self.set_gravity(-EARTH_GRAVITY / meters_per_unit(self._scene.prim.GetStage()))
            self.enable_ccd(True)
            self.set_physics_dt(1.0 / 60.0)
        for name, value in (sim_params or {}).items():
            self._set_parameter(name, value)
        if physics_dt is not None:
            self.set_physics_dt(physics_dt)

    @property
    def prim_path(self) -> str:
        return self._scene.path

    @property
    def device(self) -> str:
        return SimulationManager.get_physics_sim_device()

    @property
    def use_gpu_sim(self) -> bool:
        return "cuda" in self.device

    use_gpu_pipeline = use_gpu_sim

    @property
    def use_fabric(self) -> bool:
        """Return False: there is no Fabric."""
        return False

    def get_current_physics_scene_prim(self) -> Usd.Prim | None:
        """Return the PhysicsScene that is simulated; None if there is none."""
        return physics_scene(used_stage.current_stage())

    def warm_start(self) -> None:
        """Do nothing, as in Isaac Sim: `SimulationManager.initialize_physics` begins to simulate."""

    # --- steps and gravity ---
    def set_physics_dt(self, dt: float = 1.0 / 60.0, substeps: int = 1) -> None:
        """Set the length of a step [s]; an app update takes as many as fit into it.

        Raises:
            ValueError: `dt` is not within 0 and 1.
        """
        self._scene.set_dt(dt)

    def get_physics_dt(self) -> float:
        return self._scene.get_dt()

    def set_gravity(self, value: float) -> None:
        """Set gravity along the up axis [stage units/s²]; negative values pull down."""
        axis = up_axis(self._scene.prim.GetStage())
        down = -1.0 if value <= 0.0 else 1.0
        scene = self._scene.physics_scene
        scene.CreateGravityDirectionAttr().Set(Gf.Vec3f(*(down * (each == axis) for each in "XYZ")))
        scene.CreateGravityMagnitudeAttr().Set(abs(float(value)))

    def get_gravity(self) -> tuple[list[float], float]:
        """Return direction (3,) and magnitude [stage units/s²]."""
        gravity = self._scene.get_gravity()
        length = gravity.GetLength()
        return list(gravity / length if length else Gf.Vec3f(0.0)), length

    # --- settings of PhysX, which are kept on the stage ---
    def enable_ccd(self, flag: bool) -> None:
        self._scene.set_enabled_ccd(flag)

    def is_ccd_enabled(self) -> bool:
        return self._scene.get_enabled_ccd()

    def enable_gpu_dynamics(self, flag: bool) -> None:
        self._scene.set_enabled_gpu_dynamics(flag)

    def is_gpu_dynamics_enabled(self) -> bool:
        return self._scene.get_enabled_gpu_dynamics()

    def enable_stablization(self, flag: bool) -> None:
        self._scene.set_enabled_stabilization(flag)

    enable_stabilization = enable_stablization

    def is_stablization_enabled(self) -> bool:
        return self._scene.get_enabled_stabilization()

    def set_broadphase_type(self, broadcast_type: str) -> None:
        self._scene.set_broadphase_type(broadcast_type)

    def get_broadphase_type(self) -> str:
        return self._scene.get_broadphase_type()

    def set_solver_type(self, solver_type: str) -> None:
        self._scene.set_solver_type(solver_type)

    def get_solver_type(self) -> str:
        return self._scene.get_solver_type()

    def set_bounce_threshold(self, value: float) -> None:
        self._scene.set("BounceThreshold", float(value))

    def get_bounce_threshold(self) -> float:
        return self._scene.get("BounceThreshold")

    def enable_fabric(self, enable: bool) -> None:
        """Do nothing: there is no Fabric, and every step writes its result to the stage."""

    def _set_parameter(self, name: str, value: Any) -> None:
        if name == "dt":
            self.set_physics_dt(value)
            self._scene.prim.GetStage().SetTimeCodesPerSecond(1.0 / value)
        elif name == "gravity":
            axis = up_axis(self._scene.prim.GetStage())
            self.set_gravity(value["XYZ".index(axis)])
        elif name == "solver_type":
            self.set_solver_type(value if isinstance(value, str) else ("PGS", "TGS")[bool(value)])
        elif name == "default_physics_material":
            self._bind_default_material(value)
        elif name in _PARAMETERS:
            self._scene.set(_PARAMETERS[name], value)
        elif name not in _KNOWN and not name.startswith("gpu_"):
            warn_once(f"sim_params: {name!r} is ignored; it is no parameter of a PhysicsScene")

    def _bind_default_material(self, values: Mapping[str, float]) -> None:
        material = UsdShade.Material.Define(self._scene.prim.GetStage(), f"{self.prim_path}/defaultMaterial")
        api = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
        api.CreateStaticFrictionAttr().Set(values["static_friction"])
        api.CreateDynamicFrictionAttr().Set(values["dynamic_friction"])
        api.CreateRestitutionAttr().Set(values["restitution"])
        weaker = UsdShade.Tokens.weakerThanDescendants
        UsdShade.MaterialBindingAPI.Apply(self._scene.prim).Bind(material, weaker, "physics")
