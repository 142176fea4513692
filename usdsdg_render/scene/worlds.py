"""Many worlds of one scene: what differs between them, as arrays with a leading axis of worlds.

All worlds have the same prototypes, instances, material slots, textures and lights. They differ in where instances and
lights are, which instances are shown, in materials, and in the brightness, color and direction of lights and the dome.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Worlds:
    """What differs between worlds; units are those of `scene.Scene`.

    Attributes:
        local_to_world: (worlds, instances, 4, 4) float64.
        shown: (worlds, instances) bool.
        own_materials: (worlds, rows) of `scene.MATERIAL`, beside those of the scene.
        material_slots: (worlds, slots) int32, rows of the scene's materials followed by the own ones, world by world.
        lights: (worlds, lights) rows of `scene.LIGHT`.
        dome_color: (worlds, 3) float64 radiance of a texel of 1 [nits].
        dome_from_world: (worlds, 3, 3) float32.
    """

    local_to_world: np.ndarray
    shown: np.ndarray
    own_materials: np.ndarray
    material_slots: np.ndarray
    lights: np.ndarray
    dome_color: np.ndarray
    dome_from_world: np.ndarray

    def __len__(self) -> int:
        return len(self.local_to_world)
