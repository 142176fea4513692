"""`omni.physx.bindings._physx`: what contacts, triggers and steps are reported with."""

from usdsdg.compat.omni.physics.physics_events import (
    ContactData,
    ContactDataVector,
    ContactEventHeader,
    ContactEventHeaderVector,
    ContactEventType,
    FrictionAnchor,
    FrictionAnchorsDataVector,
    TriggerEventData,
    TriggerEventType,
)
from usdsdg.compat.omni.physx import (
    PhysxInterface,
    PhysxSimulationInterface,
    SceneQueryInterface,
    acquire_physx_interface,
    acquire_physx_simulation_interface,
)
from usdsdg.compat.omni.physx import get_physx_scene_query_interface as acquire_physx_scene_query_interface

PhysX, IPhysxSimulation, PhysXSceneQuery = PhysxInterface, PhysxSimulationInterface, SceneQueryInterface

__all__ = [
    "ContactData", "ContactDataVector", "ContactEventHeader", "ContactEventHeaderVector", "ContactEventType",
    "FrictionAnchor", "FrictionAnchorsDataVector", "IPhysxSimulation", "PhysX", "PhysXSceneQuery", "TriggerEventData",
    "TriggerEventType", "acquire_physx_interface", "acquire_physx_scene_query_interface",
    "acquire_physx_simulation_interface",
]  # fmt: skip
