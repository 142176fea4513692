"""Lights on the device: their rows, and the patterns and rules that rows point to."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from usdsdg_render.lights.emissive_instances import Emitter, find_emitters
from usdsdg_render.lights.power import extents, strengths
from usdsdg_render.scene import structs
from usdsdg_render.scene.scene import LightPattern, LightRules, Scene
from usdsdg_render.scene.struct_rows import records, uploaded
from usdsdg_render.scene.structs import LIGHT_DISTANT, LIGHT_MESH

_LIT, _CASTING = 1, 2


class LightTables:
    """Uploads the lights of a scene, all but the dome, and keeps alive what they point to."""

    def __init__(self, device: str) -> None:
        self.device = device
        self.near = self.distant = 0.0  # sums of the strengths of lights
        self._patterns: dict[int, tuple[LightPattern, wp.array, list[wp.array]]] = {}
        self._rules: list[wp.array] = []
        self._shares: list[wp.array] = []

    def upload(self, scene: Scene, tables: Any) -> None:
        """Fill the lights of `structs.SceneTables`."""
        # Lights that a ray can meet first: the loop over them then ends early.
        delta = (scene.lights["kind"] == LIGHT_DISTANT) & (scene.lights["cos_angle"] >= 1.0)
        lights = scene.lights[np.argsort(delta, kind="stable")]
        emitters = find_emitters(scene)
        count = len(lights)
        table = records(structs.Light, count + len(emitters))
        rows = table[:count]
        for name in lights.dtype.names or ():
            if name not in ("power", "pattern", "rules"):
                rows[name] = lights[name]
        rows["strength"], rows["extent"] = strengths(lights, scene.light_patterns), extents(lights)
        # The last address stands for none, which is row -1.
        rows["pattern"] = np.array([*self._upload_patterns(scene.light_patterns), 0], np.uint64)[lights["pattern"]]
        rows["rules"] = np.array([*self._upload_rules(scene.light_rules), 0], np.uint64)[lights["rules"]]
        self._write_emitters(emitters, table[count:])
        tables.surface_count = int((~delta).sum())
        tables.instance_light = self._array(_rows_of(emitters, count, len(scene.instances)), wp.int32)
        tables.emitter_count = len(emitters)
        tables.lights = uploaded(table, structs.Light, self.device)
        tables.light_count = len(table)
        distant = table["kind"] == LIGHT_DISTANT
        self.near, self.distant = (float(table["strength"][some].sum()) for some in (~distant, distant))

    def _write_emitters(self, emitters: list[Emitter], rows: np.ndarray) -> None:
        self._shares = [self._array(each.shares, wp.float32) for each in emitters]
        for row, each, shares in zip(rows, emitters, self._shares, strict=True):
            row["kind"], row["instance"], row["glow"] = LIGHT_MESH, each.instance, each.glow
            row["faces"], row["face_count"] = shares.ptr, len(each.shares) - 1
            row["position"], row["extent"], row["shaping_cos"] = each.center, each.radius, -1.0
            # Half of what glows faces a point, on average at half its area, from both of its sides.
            row["strength"] = each.glow / 2.0

    def _array(self, values: np.ndarray, dtype: Any) -> wp.array:
        return wp.array(values, dtype=dtype, device=self.device)

    def _upload_patterns(self, patterns: list[LightPattern]) -> list[int]:
        held = {}
        for pattern in patterns:
            held[id(pattern)] = self._patterns.get(id(pattern)) or (pattern, *self._upload_pattern(pattern))
        self._patterns = held
        return [held[id(pattern)][1].ptr for pattern in patterns]

    def _upload_pattern(self, pattern: LightPattern) -> tuple[wp.array, list[wp.array]]:
        row = records(structs.LightPattern, 1)
        parts = []
        if pattern.profile is not None:
            parts.append(self._array(np.ascontiguousarray(pattern.profile, np.float32).reshape(-1), wp.float32))
            row["profile"] = parts[-1].ptr
            row["profile_height"], row["profile_width"] = pattern.profile.shape
        if pattern.picture is not None:
            parts.append(self._array(np.ascontiguousarray(pattern.picture, np.float32).reshape(-1, 3), wp.vec3))
            row["texels"] = parts[-1].ptr
            row["height"], row["width"] = pattern.picture.shape[:2]
        return uploaded(row, structs.LightPattern, self.device), parts

    def _upload_rules(self, rules: list[LightRules]) -> list[int]:
        addresses, held = [], []
        for rule in rules:
            row = records(structs.LightRules, 1)
            if rule.lit is not None or rule.casting is not None:
                lit = np.uint8(_LIT) if rule.lit is None else rule.lit * np.uint8(_LIT)
                casting = np.uint8(_CASTING) if rule.casting is None else rule.casting * np.uint8(_CASTING)
                held.append(self._array(np.asarray(lit | casting, np.uint8), wp.uint8))
                row["links"] = held[-1].ptr
            for name in ("shadow_color", "shadow_distance", "shadow_falloff", "shadow_gamma"):
                row[name] = getattr(rule, name)
            held.append(uploaded(row, structs.LightRules, self.device))
            addresses.append(held[-1].ptr)
        self._rules = held
        return addresses


def _rows_of(emitters: list[Emitter], first: int, instances: int) -> np.ndarray:
    """Per instance its row in the table of lights, or -1; empty without emitters."""
    rows = np.full(instances if emitters else 0, -1, np.int32)
    for k, each in enumerate(emitters):
        rows[each.instance] = first + k
    return rows
