"""Reader of all lights but domes: rows of `scene.LIGHT`, emission profiles and light links."""

from collections.abc import Mapping, Sequence, Set
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd

from usdsdg.stage.changes import is_below
from usdsdg_render.images.image_files import stamp
from usdsdg_render.lights.emission_profiles import profile_files, read_emission_profile
from usdsdg_render.lights.light_inputs import LightInputs, read_inputs
from usdsdg_render.lights.light_rows import light_rows
from usdsdg_render.lights.light_values import emitted_color
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
    """What was read of one light, which is the same wherever it stands."""

    luminance: np.ndarray | None  # see `emitted_color`; None if it is off
    inputs: LightInputs | None  # None if they were not needed yet, since it is off
    instances: Sequence[str] | None  # for which its links were read; None without links
    profile: EmissionProfile | None
    links: LightLinks | None
    files: tuple[str, ...]  # of the profile
    stamp: tuple[int, int]  # of these, when they were read

    def with_emission(self, prim: Usd.Prim) -> "_Light":
        """Read how bright it is, and of what color."""
        luminance, inputs = emitted_color(prim), self.inputs
        if luminance is None or not luminance.any():
            luminance = None
        elif inputs is None:
            inputs = read_inputs(prim)
        return self._replace(luminance=luminance, inputs=inputs)


class LightReader:
    """Reads lights; keeps what it read of each until that is invalidated, or its links may refer to other instances."""

    def __init__(self) -> None:
        self._known: dict[Sdf.Path, _Light] = {}
        self._other_emission: set[Sdf.Path] = set()  # lights of which brightness and color are to be read again

    def invalidate(self, roots: Set[Sdf.Path]) -> None:
        """Drop the cached lights at and below `roots`."""
        if roots:
            self._known = {path: light for path, light in self._known.items() if not is_below(path, roots)}

    def invalidate_emission(self, paths: Set[Sdf.Path]) -> None:
        """Let brightness and color alone of the cached lights at `paths` be read again."""
        self._other_emission |= paths

    def with_other_files(self) -> set[Sdf.Path]:
        """Return the lights whose files have changed since they were read."""
        return {path for path, light in self._known.items() if light.files and stamp(light.files) != light.stamp}

    def read(
        self, prims: Sequence[Usd.Prim], local_to_world: np.ndarray, meters_per_unit: float, instances: Sequence[str]
    ) -> Lights:
        """Read the lights at `prims`, placed by `local_to_world` (N, 4, 4).

        instances: the paths of `scene.Instances`.
        """
        before, self._known = self._known, {}
        sources: list[str] = []
        for prim in prims:
            path = prim.GetPath()
            light = before.get(path)
            if light is None or not (light.instances is None or light.instances is instances):
                linked = is_linked(prim)
                if linked and not sources:
                    sources = [source_path(each) for each in instances]
                light = _read(prim, instances if linked else None, sources).with_emission(prim)
            elif path in self._other_emission:
                light = light.with_emission(prim)
            self._known[path] = light
        self._other_emission = set()
        return _combined(self._known, np.asarray(local_to_world), meters_per_unit)


def _read(prim: Usd.Prim, instances: Sequence[str] | None, sources: Sequence[str]) -> _Light:
    """Read all but the emission of a light."""
    files = profile_files(prim)
    profile, links = read_emission_profile(prim), read_links(prim, sources)
    return _Light(None, None, instances, profile, links, files, stamp(files) if files else (0, 0))


def _combined(known: Mapping[Sdf.Path, _Light], local_to_world: np.ndarray, meters_per_unit: float) -> Lights:
    """Return the tables of the lights by path, in the order of their matrices (N, 4, 4)."""
    on = [(place, path) for place, (path, light) in enumerate(known.items()) if light.luminance is not None]
    if not on:
        return Lights(np.zeros(0, LIGHT), [], [], False)
    places, paths = zip(*on, strict=True)
    lights = [known[path] for path in paths]
    inputs = [light.inputs for light in lights if light.inputs is not None]
    luminances = np.array([light.luminance for light in lights])
    rows, are_lit = light_rows(paths, inputs, luminances, local_to_world[list(places)], meters_per_unit)
    links: list[LightLinks] = []
    profiles: dict[int, tuple[int, EmissionProfile]] = {}
    lit = [light for light, is_lit in zip(lights, are_lit, strict=True) if is_lit]
    rows = rows[are_lit]
    for row, light in enumerate(lit):
        if light.profile is not None:
            known_as = profiles.setdefault(id(light.profile), (len(profiles), light.profile))
            rows["emission_profile"][row] = known_as[0]
        if light.links is not None:
            rows["links"][row] = len(links)
            links.append(light.links)
    linked = any(light.instances is not None for light in lit)
    return Lights(rows, [profile for _, profile in profiles.values()], links, linked)


def _content(links: LightLinks) -> tuple:
    members = (None if m is None else m.tobytes() for m in (links.lit, links.casting))
    return *members, links.shadow_color, links.shadow_distance, links.shadow_falloff, links.shadow_gamma
