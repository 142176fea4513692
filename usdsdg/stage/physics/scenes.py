"""The PhysicsScene that is simulated, and its step rate."""

from collections.abc import Iterable

from pxr import Sdf, Usd, UsdPhysics

PATH = "/PhysicsScene"
STEP_RATE = "physxScene:timeStepsPerSecond"
DEFAULT_STEP_RATE = 60
# m/s², where no gravity is authored.
EARTH_GRAVITY = 9.81


def physics_scene(stage: Usd.Stage) -> Usd.Prim | None:
    """Return the PhysicsScene that is simulated, or None when the stage has none."""
    return simulated_scene(prim for prim in stage.Traverse() if prim.IsA(UsdPhysics.Scene))


def simulated_scene(scenes: Iterable[Usd.Prim]) -> Usd.Prim | None:
    """Return the PhysicsScene among several that is simulated: the first by path; None when there are none."""
    return min(scenes, key=lambda prim: prim.GetPath(), default=None)


def needed_physics_scene(stage: Usd.Stage) -> Usd.Prim:
    """Return the PhysicsScene that is simulated; define /PhysicsScene when the stage has none."""
    return physics_scene(stage) or UsdPhysics.Scene.Define(stage, PATH).GetPrim()


def steps_per_second(scene: Usd.Prim | None) -> float:
    """Return a PhysicsScene's steps per second of simulated time; 60 without a scene or value."""
    value = scene.GetAttribute(STEP_RATE).Get() if scene else None
    return float(DEFAULT_STEP_RATE if value is None else value)


def step_rate_attribute(scene: Usd.Prim) -> Usd.Attribute:
    """Return a PhysicsScene's attribute of steps per second (a whole number), created where it is missing."""
    return scene.CreateAttribute(STEP_RATE, Sdf.ValueTypeNames.UInt, custom=False)


def set_steps_per_second(stage: Usd.Stage, rate: float) -> None:
    """Author the step rate, rounded to a whole number, on the simulated PhysicsScene; define one if there is none."""
    step_rate_attribute(needed_physics_scene(stage)).Set(max(1, round(rate)))
