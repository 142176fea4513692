"""The behavior that drops assets onto prims and pushes them together, until they lie in a stack."""

from __future__ import annotations

import asyncio
import enum
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from usdsdg.app.app import get_app
from usdsdg.compat.carb.eventdispatcher import Event, get_eventdispatcher
from usdsdg.compat.isaacsim.replicator.behavior.base_behavior import Variable, variable
from usdsdg.compat.isaacsim.replicator.behavior.global_variables import EXTENSION_NAME, SCOPE_NAME
from usdsdg.compat.isaacsim.replicator.behavior.prims_behavior import INCLUDE_CHILDREN, SEED, RandomBehavior
from usdsdg.compat.isaacsim.replicator.behavior.utils import scene_utils
from usdsdg.compat.isaacsim.replicator.behavior.utils.asset_lists import asset_files
from usdsdg.compat.isaacsim.replicator.behavior.utils.behavior_utils import remove_empty_scopes
from usdsdg.compat.isaacsim.replicator.behavior.utils.collision_walls import scaled_box
from usdsdg.compat.isaacsim.replicator.physics_steps import apply_forces
from usdsdg.stage.paths import next_free_path

_T = Sdf.ValueTypeNames
_PROPS = "/Isaac/Environments/Simple_Warehouse/Props"

# Steps of the phases.
_STEPS_BETWEEN_DROPS, _STEPS_TO_SETTLE, _STEPS_AT_END = 10, 100, 20
_STEPS_PER_PUSH, _STEPS_PER_PULL = 25, 20
# Forces in the stage's units, and the part of them, per unit of distance, that pulls toward the prim.
_PUSH, _PULL, _TOWARDS_PRIM = 500.0, 250.0, 0.2
_SIDES = ((0, 1, 0), (1, 0, 0), (0, -1, 0), (-1, 0, 0))
_SLIPPERY, _ROUGH = 0.001, 0.95  # friction while they fall, and afterward
_QUARTER_TURNS = (180, 90, 0, -90, -180)


class BehaviorState(enum.Enum):
    """What a `VolumeStackRandomizer` is doing."""

    INIT = 0
    SETUP = 1
    RUNNING = 2
    FINISHED = 3
    RESET = 4


class VolumeStackRandomizer(RandomBehavior):
    """Drops assets onto each gprim, between invisible walls; it is driven by events, not by the timeline.

    An event `EVENT_NAME_IN` has the payload {"action": "setup", "run" or "reset"}, with "prim_path" for one prim only.
    `event:output` is dispatched with prim_path, state and state_name whenever the state changes.
    """

    BEHAVIOR_NS: ClassVar[str] = "volumeStackRandomizer"
    EVENT_NAME_IN: ClassVar[str] = f"{EXTENSION_NAME}.{BEHAVIOR_NS}.in"
    EVENT_NAME_OUT: ClassVar[str] = f"{EXTENSION_NAME}.{BEHAVIOR_NS}.out"
    VARIABLES_TO_EXPOSE: ClassVar[list[Variable]] = [
        INCLUDE_CHILDREN,
        variable("event:input", _T.String, EVENT_NAME_IN, "Event that drives the behavior; read only.", lock=True),
        variable("event:output", _T.String, EVENT_NAME_OUT, "Event that tells its state."),
        variable("assets:assets", _T.AssetArray, [], "Assets to drop."),
        variable(
            "assets:csv",
            _T.String,
            f"{_PROPS}/SM_CardBoxC_01.usd,{_PROPS}/SM_CardBoxD_01.usd",
            "More assets: URLs, or paths under the assets root, separated by commas.",
        ),
        variable("assets:numRange", _T.Int2, Gf.Vec2i(4, 8), "Smallest and largest number of assets per prim."),
        variable("dropHeight", _T.Float, 2.0, "Height above the prim from which assets fall [stage units]."),
        variable("renderSimulation", _T.Bool, True, "Update the application after every step."),
        variable("removeRigidBodyDynamics", _T.Bool, True, "Assets are no rigid bodies any more afterward."),
        variable("preserveSimulationState", _T.Bool, True, "Assets stay where they are when the timeline stops."),
        SEED,
    ]

    def on_init(self) -> None:
        self._assets: dict[Usd.Prim, list[Usd.Prim]] = {}
        self._walls: dict[Usd.Prim, list[Usd.Prim]] = {}
        self._material: UsdShade.Material | None = None
        self._preserve = self._reset_requested = False
        self._task: asyncio.Future[None] | None = None  # asyncio itself keeps no reference to a task
        self._event_out = self.EVENT_NAME_OUT
        dispatcher = get_eventdispatcher()
        self._observer = dispatcher.observe_event(event_name=self.EVENT_NAME_IN, on_event=self._on_event)
        super().on_init()
        self._set_state(BehaviorState.INIT)

    def on_destroy(self) -> None:
        self._observer.reset()
        super().on_destroy()

    # The timeline does not drive it.
    def on_play(self) -> None:
        """Do nothing: events drive this behavior."""

    def on_stop(self) -> None:
        """Do nothing: events drive this behavior."""

    def on_update(self, current_time: float, delta_time: float) -> None:
        """Do nothing: events drive this behavior."""

    def _applies_to(self, prim: Usd.Prim) -> bool:
        return prim.IsA(UsdGeom.Gprim)

    # --- events ---
    def _on_event(self, event: Event) -> None:
        if event.get("prim_path") not in (None, "", str(self.prim_path)):
            return
        action = event.get("action")
        if action == "setup":
            self._task = asyncio.ensure_future(self._setup())
        elif action == "run":
            self._task = asyncio.ensure_future(self._run())
        elif action == "reset" and self._state is BehaviorState.RUNNING:
            self._reset_requested = True  # `_run` resets after its current phase
        elif action == "reset":
            self._reset()

    def _set_state(self, state: BehaviorState) -> None:
        self._state = state
        payload = {"prim_path": str(self.prim_path), "state": state.value, "state_name": state.name}
        get_eventdispatcher().dispatch_event(self._event_out, payload)

    async def _setup(self) -> None:
        """Read the variables, and create the assets and walls of each prim."""
        self._event_out = self._get_exposed_variable("event:output")
        self._drop_height = float(self._get_exposed_variable("dropHeight"))
        self._render = bool(self._get_exposed_variable("renderSimulation"))
        self._remove_dynamics = bool(self._get_exposed_variable("removeRigidBodyDynamics"))
        self._preserve = bool(self._get_exposed_variable("preserveSimulationState"))
        self._step_dt = 1.0 / self.stage.GetTimeCodesPerSecond()
        self._begin()
        files = asset_files(self._get_exposed_variable("assets:assets"), self._get_exposed_variable("assets:csv"))
        if files:
            self._create(files)
        self._set_state(BehaviorState.SETUP)

    async def _run(self) -> None:
        """Drop the assets, push them from all sides, and pull them together."""
        self._set_state(BehaviorState.RUNNING)
        if self._preserve:
            scene_utils.disable_simulation_reset_on_stop()
        phases = [
            *(lambda batch=batch: self._drop(batch) for batch in self._batches()),
            lambda: self._simulate(_STEPS_TO_SETTLE),
            *(lambda side=side: self._push(side, _PUSH, _STEPS_PER_PUSH) for side in 2 * _SIDES),
            *2 * (lambda: self._push((0, 0, 0), _PULL, _STEPS_PER_PULL),),
            self._finish,
        ]
        for phase in phases:
            await phase()
            if self._reset_requested:
                self._reset()
                return
        if self._preserve:
            scene_utils.reset_simulation_and_enable_reset_on_stop()
        self._set_state(BehaviorState.FINISHED)

    def _reset(self) -> None:
        """Remove all that the behavior has created."""
        if self._preserve and self._state is not BehaviorState.FINISHED and self._assets:
            scene_utils.disable_simulation_reset_on_stop()
            scene_utils.reset_simulation_and_enable_reset_on_stop()
        self._remove_walls()
        for asset in (asset for assets in self._assets.values() for asset in assets if asset):
            self.stage.RemovePrim(asset.GetPath())
        self._assets.clear()
        if self._material:
            self.stage.RemovePrim(self._material.GetPath())
        self._material, self._reset_requested = None, False
        remove_empty_scopes(self.stage.GetPrimAtPath(SCOPE_NAME), self.stage)
        super()._reset()
        self._set_state(BehaviorState.RESET)

    # --- the scene ---
    def _create(self, files: Sequence[str]) -> None:
        scope = f"{SCOPE_NAME}/{self.BEHAVIOR_NS}"
        path = next_free_path(self.stage, f"{scope}/PhysicsMaterial", False)
        self._material = scene_utils.create_physics_material(self.stage, path, 0.0, _SLIPPERY, _SLIPPERY)
        low, high = self._get_exposed_variable("assets:numRange")
        bounds = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_])
        for prim in self._valid_prims:
            # Beside the prim, not below it, so that its scale does not act on them.
            root = next_free_path(self.stage, f"{scope}/Assets/{prim.GetName()}", False)
            count = self._rng.integers(low, high + 1)
            chosen = self._rng.choice(list(files), size=count).tolist()
            made = [self._create_asset(prim, file, f"{root}/Asset_{i}") for i, file in enumerate(chosen)]
            bounds.Clear()
            made.sort(key=lambda asset: bounds.ComputeWorldBound(asset).GetVolume(), reverse=True)  # largest first
            self._assets[prim] = made
            self._walls[prim] = scene_utils.create_collision_walls(
                self.stage,
                prim,
                f"{scope}/CollisionWalls/{prim.GetName()}",
                self._drop_height,
                physics_material=self._material,
                bbox_cache=bounds,
            )

    def _create_asset(self, prim: Usd.Prim, file: str, path: str) -> Usd.Prim:
        asset = scene_utils.create_asset(self.stage, file, path)
        binding = UsdShade.MaterialBindingAPI.Apply(asset)
        binding.Bind(self._material, UsdShade.Tokens.weakerThanDescendants, "physics")
        scene_utils.disable_colliders(asset)
        scene_utils.disable_rigid_body_dynamics(asset)
        location, rotation = scene_utils.get_world_location(prim), scene_utils.get_world_rotation(prim)
        scene_utils.set_transform_attributes(asset, location=location, orientation=rotation.GetQuat())
        return asset

    def _remove_walls(self) -> None:
        for walls in self._walls.values():
            self.stage.RemovePrim(walls[0].GetParent().GetPath())
        self._walls.clear()

    # --- phases ---
    def _batches(self) -> list[list[tuple[Usd.Prim, Usd.Prim]]]:
        """Return what falls at the same time: one asset of each prim."""
        most = max(map(len, self._assets.values()), default=0)
        return [
            [(prim, made[index]) for prim, made in self._assets.items() if index < len(made)] for index in range(most)
        ]

    async def _drop(self, batch: Sequence[tuple[Usd.Prim, Usd.Prim]]) -> None:
        bounds = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_])
        for prim, asset in batch:
            middle, (width, depth, tall) = scaled_box(bounds.ComputeWorldBound(prim))
            room = min(width, depth) / 2.0 - max(bounds.ComputeWorldBound(asset).GetRange().GetSize()) / 2.0
            aside = [self._rng.uniform(-room, room) if room > 0.0 else 0.0 for _ in range(2)]
            turns = [float(self._rng.choice(_QUARTER_TURNS)) for _ in range(3)]
            above = middle + Gf.Vec3d(*aside, tall / 2.0 + self._drop_height)
            world = Gf.Matrix4d(scene_utils.get_world_rotation(prim), scene_utils.get_world_location(prim))
            rotation = world.ExtractRotation()
            for axis, turn in reversed(list(enumerate(turns))):
                rotation = Gf.Rotation(Gf.Vec3d.Axis(axis), turn) * rotation
            scene_utils.set_transform_attributes(asset, location=world.Transform(above), orientation=rotation.GetQuat())
            scene_utils.add_colliders(asset)
            scene_utils.add_rigid_body_dynamics(asset, angular_damping=10.0, linear_damping=0.01)
        await self._simulate(_STEPS_BETWEEN_DROPS)

    async def _push(self, side: Sequence[float], strength: float, steps: int) -> None:
        """Push all assets along a direction of their prim's frame and toward the prim, during the first step."""
        bodies, forces, positions = [], [], []
        cache = UsdGeom.XformCache()
        for prim, made in self._assets.items():
            center = scene_utils.get_world_location(prim, cache)
            direction = scene_utils.get_world_rotation(prim, cache).TransformDir(Gf.Vec3d(*side))
            for asset in made:
                at = scene_utils.get_world_location(asset, cache)
                bodies.append(str(asset.GetPath()))
                forces.append(strength * (direction + _TOWARDS_PRIM * (center - at)))
                positions.append(at)
        apply_forces(bodies, np.array(forces).reshape(-1, 3), np.array(positions).reshape(-1, 3))
        await self._simulate(steps)

    async def _simulate(self, steps: int) -> None:
        await scene_utils.run_simulation_async(steps, self._step_dt, self._render)

    async def _finish(self) -> None:
        """Let the assets come to rest, without walls and with friction."""
        await self._simulate(_STEPS_AT_END)
        if not self._render:
            await get_app().next_update_async()
        if self._material:
            physics = UsdPhysics.MaterialAPI(self._material.GetPrim())
            physics.GetStaticFrictionAttr().Set(_ROUGH)
            physics.GetDynamicFrictionAttr().Set(_ROUGH)
        if self._remove_dynamics:
            for asset in (asset for made in self._assets.values() for asset in made):
                UsdPhysics.RigidBodyAPI(asset).GetRigidBodyEnabledAttr().Set(False)
        self._remove_walls()
        scope = self.stage.GetPrimAtPath(f"{SCOPE_NAME}/{self.BEHAVIOR_NS}")
        remove_empty_scopes(scope, self.stage)
