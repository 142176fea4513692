"""Emissive instances that are sampled as area lights: their power, bounds and triangle CDFs."""

from typing import NamedTuple

import numpy as np

from usdsdg.stage.colors import LUMINANCE
from usdsdg_render.scene.scene import Scene

# Only this many of the brightest instances are sampled as lights, if they emit at least that fraction of all power.
# Every shading point evaluates the weight of every light: with 64 lamps that costs what it saves. Other instances
# contribute through BSDF sampling alone.
MAX_EMISSIVE_LIGHTS = 32
MIN_POWER_FRACTION = 1e-3


class EmissiveInstance(NamedTuple):
    """One emissive instance."""

    instance: int
    luminance_area: float  # luminance times world area, summed over its triangles [nit * stage unit^2]
    center: np.ndarray  # (3,) of the bounding sphere of its emissive triangles
    radius: float
    face_cdf: np.ndarray  # (T + 1,) float32 CDF over its triangles, from 0 to 1


def find_emissive_instances(scene: Scene) -> list[EmissiveInstance]:
    """Find the brightest emissive instances of a scene, brightest first; emission textures count as white."""
    luminance = np.nan_to_num(scene.materials["emission"].astype(np.float64) @ LUMINANCE, posinf=0.0, neginf=0.0)
    emissive = luminance > 0.0
    if not emissive.any():
        return []
    candidates = _has_emission(scene, emissive[scene.material_slots])
    found = [_emissive_instance(scene, k, luminance) for k in np.flatnonzero(candidates)]
    brightest = sorted((each for each in found if each is not None), key=lambda each: -each.luminance_area)
    least = MIN_POWER_FRACTION * sum(each.luminance_area for each in brightest)
    return [each for each in brightest[:MAX_EMISSIVE_LIGHTS] if each.luminance_area >= least]


def _has_emission(scene: Scene, slots: np.ndarray) -> np.ndarray:
    """(instances,) bool: whether a material slot of the instance is emissive."""
    counts = np.array([p.triangle_slots.max(initial=-1) + 1 for p in scene.prototypes], np.int64)
    running = np.append(0, np.cumsum(slots))
    first = scene.instances.slot_offset
    return running[first + counts[scene.instances.prototype]] > running[first] if len(first) else np.zeros(0, bool)


def _emissive_instance(scene: Scene, instance: int, luminance: np.ndarray) -> EmissiveInstance | None:
    prototype = scene.prototypes[scene.instances.prototype[instance]]
    matrix = scene.instances.local_to_world[instance]
    corners = (prototype.points @ matrix[:3, :3])[prototype.triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2.0
    slots = scene.instances.slot_offset[instance] + prototype.triangle_slots
    power = area * luminance[scene.material_slots[slots]]
    luminance_area = float(power.sum())
    if not np.isfinite(luminance_area) or luminance_area <= 0.0:
        return None
    face_cdf = np.append(0.0, np.cumsum(power) / luminance_area)
    face_cdf[-1] = 1.0
    bright = corners[power > 0.0].reshape(-1, 3)
    lower, upper = bright.min(0), bright.max(0)
    center = (lower + upper) / 2.0
    radius = float(np.linalg.norm(bright - center, axis=1).max())
    return EmissiveInstance(instance, luminance_area, center + matrix[3, :3], radius, face_cdf.astype(np.float32))
