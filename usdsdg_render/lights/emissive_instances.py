"""Instances that glow, as lights: rows beside those of `scene.LIGHT`, and shares of their triangles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from usdsdg.stage.colors import LUMINANCE
from usdsdg_render.scene.scene import Scene

# The brightest so many are drawn from, and of them those that give at least that share of the light of all. Every point
# weighs every light: 64 lamps take as much time as they save. The others are found by following paths.
MOST_EMITTERS = 32
LEAST_SHARE = 1e-3


class Emitter(NamedTuple):
    """One glowing instance."""

    instance: int
    glow: float  # luminance times area of all its triangles in the world [nit * stage unit^2]
    center: np.ndarray  # (3,) of a ball that holds what glows
    radius: float
    shares: np.ndarray  # (T + 1,) float32 running sums over its triangles, from 0 to 1


def find_emitters(scene: Scene) -> list[Emitter]:
    """The brightest glowing instances of a scene, brightest first; textures of what they give off count as white."""
    luminance = np.nan_to_num(scene.materials["emission"].astype(np.float64) @ LUMINANCE, posinf=0.0, neginf=0.0)
    glowing = luminance > 0.0
    if not glowing.any():
        return []
    may_glow = _may_glow(scene, glowing[scene.material_slots])
    found = [_emitter(scene, k, luminance) for k in np.flatnonzero(may_glow)]
    brightest = sorted((each for each in found if each is not None), key=lambda each: -each.glow)
    least = LEAST_SHARE * sum(each.glow for each in brightest)
    return [each for each in brightest[:MOST_EMITTERS] if each.glow >= least]


def _may_glow(scene: Scene, slots: np.ndarray) -> np.ndarray:
    """(instances,) bool: whether a slot of the instance's prototype glows."""
    counts = np.array([p.triangle_slots.max(initial=-1) + 1 for p in scene.prototypes], np.int64)
    running = np.append(0, np.cumsum(slots))
    first = scene.instances.slot_offset
    return running[first + counts[scene.instances.prototype]] > running[first] if len(first) else np.zeros(0, bool)


def _emitter(scene: Scene, instance: int, luminance: np.ndarray) -> Emitter | None:
    prototype = scene.prototypes[scene.instances.prototype[instance]]
    matrix = scene.instances.local_to_world[instance]
    corners = (prototype.points @ matrix[:3, :3])[prototype.triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2.0
    slots = scene.instances.slot_offset[instance] + prototype.triangle_slots
    power = area * luminance[scene.material_slots[slots]]
    glow = float(power.sum())
    if not np.isfinite(glow) or glow <= 0.0:
        return None
    shares = np.append(0.0, np.cumsum(power) / glow)
    shares[-1] = 1.0
    bright = corners[power > 0.0].reshape(-1, 3)
    lower, upper = bright.min(0), bright.max(0)
    center = (lower + upper) / 2.0
    radius = float(np.linalg.norm(bright - center, axis=1).max())
    return Emitter(instance, glow, center + matrix[3, :3], radius, shares.astype(np.float32))
