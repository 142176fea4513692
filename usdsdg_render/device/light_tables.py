"""Lights on the device: their rows, and the emission profiles and light links that rows point to."""

from typing import Any

import numpy as np
import warp as wp

from usdsdg_render.lights.emissive_instances import EmissiveInstance, find_emissive_instances
from usdsdg_render.lights.power import extents, strengths
from usdsdg_render.scene import structs
from usdsdg_render.scene.scene import EmissionProfile, LightLinks, Scene
from usdsdg_render.scene.struct_rows import records, uploaded
from usdsdg_render.scene.structs import LIGHT_DISTANT, LIGHT_MESH

_LIT, _CASTING = 1, 2


class LightTables:
    """Uploads all lights of a scene except the dome, and keeps alive the memory that their rows point to."""

    def __init__(self, device: str) -> None:
        self.device = device
        self.local_strength = self.distant_strength = 0.0  # sums over lights
        self._profiles: dict[int, tuple[EmissionProfile, wp.array, list[wp.array]]] = {}
        self._links: list[wp.array] = []
        self._profile_addresses = self._link_addresses = np.zeros(1, np.uint64)
        self._face_cdfs: list[wp.array] = []

    def upload(self, scene: Scene, tables: Any) -> None:
        """Fill the light tables of `structs.SceneTables`."""
        emissive = find_emissive_instances(scene)
        count = len(scene.lights)
        # Row -1 means none, so the last address is 0.
        self._profile_addresses = np.array([*self._upload_profiles(scene.emission_profiles), 0], np.uint64)
        self._link_addresses = np.array([*self._upload_links(scene.light_links), 0], np.uint64)
        own, tables.surface_count = self.rows_of(scene, scene.lights[None])
        table = records(structs.Light, count + len(emissive))
        table[:count] = own[0]
        self._write_emissive(emissive, table[count:])
        tables.instance_light = self._array(_rows_of(emissive, count, len(scene.instances)), wp.int32)
        tables.emissive_count = len(emissive)
        tables.lights = uploaded(table, structs.Light, self.device)
        tables.light_count = len(table)
        distant = table["kind"] == LIGHT_DISTANT
        strength = table["strength"]
        self.local_strength, self.distant_strength = float(strength[~distant].sum()), float(strength[distant].sum())

    def rows_of(self, scene: Scene, lights: np.ndarray) -> tuple[np.ndarray, int]:
        """Return records (worlds, lights) of the uploaded scene's lights, and how many of each world have a surface.

        lights: (worlds, lights) rows of `scene.LIGHT`, of the same kinds in all worlds.
        """
        # Delta lights last: rays cannot hit them, so the loop over hittable lights ends early.
        delta = (lights[0]["kind"] == LIGHT_DISTANT) & (lights[0]["cos_angle"] >= 1.0)
        ordered = lights[:, np.argsort(delta, kind="stable")]
        flat = ordered.reshape(-1)
        rows = records(structs.Light, len(flat))
        for name in flat.dtype.names or ():
            if name not in ("power", "emission_profile", "links"):
                rows[name] = flat[name]
        rows["strength"], rows["extent"] = strengths(flat, scene.emission_profiles), extents(flat)
        rows["emission_profile"] = self._profile_addresses[flat["emission_profile"]]
        rows["links"] = self._link_addresses[flat["links"]]
        return rows.reshape(ordered.shape), int((~delta).sum())

    def _write_emissive(self, emissive: list[EmissiveInstance], rows: np.ndarray) -> None:
        self._face_cdfs = [self._array(each.face_cdf, wp.float32) for each in emissive]
        for row, each, face_cdf in zip(rows, emissive, self._face_cdfs, strict=True):
            row["kind"], row["instance"], row["luminance_area"] = LIGHT_MESH, each.instance, each.luminance_area
            row["face_cdf"], row["face_count"] = face_cdf.ptr, len(each.face_cdf) - 1
            row["position"], row["extent"], row["shaping_cos"] = each.center, each.radius, -1.0
            # Both sides of a triangle emit. On average half of the area faces a point, at half its projected size.
            row["strength"] = each.luminance_area / 2.0

    def _array(self, values: np.ndarray, dtype: Any) -> wp.array:
        return wp.array(values, dtype=dtype, device=self.device)

    def _upload_profiles(self, profiles: list[EmissionProfile]) -> list[int]:
        held = {}
        for profile in profiles:
            held[id(profile)] = self._profiles.get(id(profile)) or (profile, *self._upload_profile(profile))
        self._profiles = held
        return [held[id(profile)][1].ptr for profile in profiles]

    def _upload_profile(self, profile: EmissionProfile) -> tuple[wp.array, list[wp.array]]:
        row = records(structs.EmissionProfile, 1)
        parts = []
        if profile.ies is not None:
            parts.append(self._array(np.ascontiguousarray(profile.ies, np.float32).reshape(-1), wp.float32))
            row["ies"] = parts[-1].ptr
            row["ies_height"], row["ies_width"] = profile.ies.shape
        if profile.texture is not None:
            parts.append(self._array(np.ascontiguousarray(profile.texture, np.float32).reshape(-1, 3), wp.vec3))
            row["texels"] = parts[-1].ptr
            row["height"], row["width"] = profile.texture.shape[:2]
        return uploaded(row, structs.EmissionProfile, self.device), parts

    def _upload_links(self, links: list[LightLinks]) -> list[int]:
        addresses, held = [], []
        for each in links:
            row = records(structs.LightLinks, 1)
            if each.lit is not None or each.casting is not None:
                lit = np.uint8(_LIT) if each.lit is None else each.lit * np.uint8(_LIT)
                casting = np.uint8(_CASTING) if each.casting is None else each.casting * np.uint8(_CASTING)
                held.append(self._array(np.asarray(lit | casting, np.uint8), wp.uint8))
                row["masks"] = held[-1].ptr
            for name in ("shadow_color", "shadow_distance", "shadow_falloff", "shadow_gamma"):
                row[name] = getattr(each, name)
            held.append(uploaded(row, structs.LightLinks, self.device))
            addresses.append(held[-1].ptr)
        self._links = held
        return addresses


def _rows_of(emissive: list[EmissiveInstance], first: int, instances: int) -> np.ndarray:
    """Return for each instance its row in the table of lights, or -1; empty if no instance is sampled as a light."""
    rows = np.full(instances if emissive else 0, -1, np.int32)
    for k, each in enumerate(emissive):
        rows[each.instance] = first + k
    return rows
