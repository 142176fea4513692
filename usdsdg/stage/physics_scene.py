"""The stage's PhysicsScene."""

from __future__ import annotations

from pxr import Sdf, Usd, UsdPhysics

PATH = "/PhysicsScene"
_RATE = "physxScene:timeStepsPerSecond"
DEFAULT_RATE = 60


def physics_scene(stage: Usd.Stage) -> Usd.Prim | None:
    """The first PhysicsScene by path, which is the one that is simulated; None when there is none."""
    scenes = [prim for prim in stage.Traverse() if prim.IsA(UsdPhysics.Scene)]
    return min(scenes, key=lambda prim: prim.GetPath(), default=None)


def needed_physics_scene(stage: Usd.Stage) -> Usd.Prim:
    """The first PhysicsScene, made at /PhysicsScene where there is none."""
    return physics_scene(stage) or UsdPhysics.Scene.Define(stage, PATH).GetPrim()


def steps_per_second(stage: Usd.Stage) -> float:
    """Physics steps in a second of simulated time."""
    scene = physics_scene(stage)
    value = scene.GetAttribute(_RATE).Get() if scene else None
    return float(DEFAULT_RATE if value is None else value)


def set_steps_per_second(stage: Usd.Stage, rate: float) -> None:
    """Author the step rate, on /PhysicsScene where there is no scene yet. The attribute holds whole numbers."""
    needed_physics_scene(stage).CreateAttribute(_RATE, Sdf.ValueTypeNames.UInt, custom=False).Set(max(1, round(rate)))
