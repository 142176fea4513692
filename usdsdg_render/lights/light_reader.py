"""Reader of all lights but domes: rows of `scene.LIGHT`, emission profiles and light links."""

from collections.abc import Iterable, Sequence, Set
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd

from usdsdg.stage.changes import is_below
from usdsdg_render.images.image_files import stamp
from usdsdg_render.lights.emission_profiles import profile_files, read_emission_profile
from usdsdg_render.lights.light_rows import read_emission, read_light
from usdsdg_render.lights.linking import is_linked, read_links
from usdsdg_render.scene.scene import LIGHT, EmissionProfile, LightLinks, Scene
from usdsdg_render.usd.point_instancer import source_path


class Lights(NamedTuple):
    """The light tables of a `Scene`."""

    table: np.ndarray
    profiles: list[EmissionProfile]
    links: list[LightLinks]
    linked: bool  # whether some light's links depend on the instances

    def write(self, scene: Scene) -> None:
        """Write the tables to a scene and mark it changed, if they differ."""
        same = self.table.tobytes() == scene.lights.tobytes()
        same = same and list(map(id, self.profiles)) == list(map(id, scene.emission_profiles))
        if same and list(map(_content, self.links)) == list(map(_content, scene.light_links)):
            return
        scene.lights, scene.emission_profiles, scene.light_links = self.table, self.profiles, self.links
        scene.touch("lights")


class _Light(NamedTuple):
    """Cached result of reading one light; row is None if it emits nothing."""

    matrix: bytes
    instances: Sequence[str] | None  # for which its links were read; None without links
    row: np.ndarray | None
    profile: EmissionProfile | None
    links: LightLinks | None
    files: tuple[str, ...]  # of the profile
    stamp: tuple[int, int]  # of these, when they were read
    has_other_emission: bool = False  # than its row has

    def with_emission(self, prim: Usd.Prim, matrix: np.ndarray, meters_per_unit: float) -> "_Light":
        """Read how bright it is and of what color; the whole row where there is none, or the light has moved."""
        key = matrix.tobytes()
        if self.row is None or self.matrix != key:
            row = read_light(prim, matrix, meters_per_unit)
        else:
            row = read_emission(prim, self.row, matrix, meters_per_unit)
        return self._replace(row=row, matrix=key, has_other_emission=False)


class LightReader:
    """Reads lights; caches each until it is invalidated, moves, or its links may refer to other instances."""

    def __init__(self) -> None:
        self._known: dict[Sdf.Path, _Light] = {}

    def invalidate(self, roots: Set[Sdf.Path]) -> None:
        """Drop the cached lights at and below `roots`."""
        if roots:
            self._known = {path: light for path, light in self._known.items() if not is_below(path, roots)}

    def invalidate_emission(self, paths: Set[Sdf.Path]) -> None:
        """Let brightness and color alone of the cached lights at `paths` be read again."""
        for path in paths & self._known.keys():
            self._known[path] = self._known[path]._replace(has_other_emission=True)

    def with_other_files(self) -> set[Sdf.Path]:
        """Return the lights whose files have changed since they were read."""
        return {path for path, light in self._known.items() if light.files and stamp(light.files) != light.stamp}

    def read(
        self,
        prims: Sequence[Usd.Prim],
        local_to_world: Sequence[np.ndarray],
        meters_per_unit: float,
        instances: Sequence[str],
    ) -> Lights:
        """Read the lights at `prims`; `instances` are the paths of `scene.Instances`."""
        before, self._known = self._known, {}
        sources: list[str] = []
        for prim, matrix in zip(prims, local_to_world):
            path, key = prim.GetPath(), matrix.tobytes()
            light = before.get(path)
            same_links = light is not None and (light.instances is None or light.instances is instances)
            if light is not None and light.has_other_emission:
                light = light.with_emission(prim, matrix, meters_per_unit)
            if light is None or light.matrix != key or not same_links:
                linked = is_linked(prim)
                if linked and not sources:
                    sources = [source_path(each) for each in instances]
                files = profile_files(prim)
                light = _Light(
                    key,
                    instances if linked else None,
                    read_light(prim, matrix, meters_per_unit),
                    read_emission_profile(prim),
                    read_links(prim, sources),
                    files,
                    stamp(files) if files else (0, 0),
                )
            self._known[path] = light
        return _combined(self._known.values())


def _combined(lights: Iterable[_Light]) -> Lights:
    rows, links = [], []
    profiles: dict[int, tuple[int, EmissionProfile]] = {}
    linked = False
    for light in lights:
        if light.row is None:
            continue
        linked = linked or light.instances is not None
        row = light.row.copy()
        if light.profile is not None:
            row["emission_profile"] = profiles.setdefault(id(light.profile), (len(profiles), light.profile))[0]
        if light.links is not None:
            row["links"] = len(links)
            links.append(light.links)
        rows.append(row)
    return Lights(np.array(rows, LIGHT), [profile for _, profile in profiles.values()], links, linked)


def _content(links: LightLinks) -> tuple:
    members = (None if m is None else m.tobytes() for m in (links.lit, links.casting))
    return *members, links.shadow_color, links.shadow_distance, links.shadow_falloff, links.shadow_gamma
