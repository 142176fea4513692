"""Keeps the lights and the dome of a `scene.Scene` in sync with a stage."""

from collections.abc import Set

from pxr import Sdf, Usd

from usdsdg.stage.poses.transforms import meters_per_unit
from usdsdg_render.images.image_files import stamp
from usdsdg_render.lights.domes import DomeBuilder, DomeLight, read_dome
from usdsdg_render.lights.light_reader import LightReader
from usdsdg_render.scene.scene import Scene
from usdsdg_render.usd.prim_kinds import DOME, LIGHT
from usdsdg_render.usd.stage_tree import StageTree


class StageLights:
    """The lights and domes of one stage; `read` updates a scene if they changed."""

    def __init__(self, stage: Usd.Stage, scene: Scene) -> None:
        self._stage, self._scene = stage, scene
        self._lights = LightReader()
        self._dome_builder = DomeBuilder()
        self._domes: list[DomeLight] = []
        self._paths: list[Sdf.Path] = []
        self._matrices = b""
        self._linked_instances: tuple[str, ...] | None = None  # for which light links were read

    def invalidate(self, roots: Set[Sdf.Path]) -> None:
        """Make `read` read the lights at and below `roots` again."""
        self._lights.invalidate(roots)

    def invalidate_emission(self, paths: Set[Sdf.Path]) -> None:
        """Make `read` read again how bright the lights at `paths` are, and of what color, but nothing else of them."""
        self._lights.invalidate_emission(paths)

    def with_other_files(self) -> set[Sdf.Path]:
        """Return the lights whose textures or profiles have changed on disk since they were read."""
        domes = {Sdf.Path(dome.path) for dome in self._domes if dome.file and stamp((dome.file,)) != dome.modified}
        return domes | self._lights.with_other_files()

    def read(self, tree: StageTree, *, always: bool) -> None:
        """Read lights if their set, a transform or the linked instances changed, or `always`; update the scene."""
        nodes = tree.of_kind(LIGHT, DOME)
        matrices = tree.world[nodes].tobytes()
        instances = self._scene.instances.paths
        same_links = self._linked_instances is None or self._linked_instances is instances
        paths = [tree.paths[node] for node in nodes]
        if not always and same_links and paths == self._paths and matrices == self._matrices:
            return
        self._paths, self._matrices = paths, matrices
        lights = [node for node in nodes if tree.kinds[node] == LIGHT]
        units = meters_per_unit(self._stage)
        read = self._lights.read([tree.prims[node] for node in lights], tree.world[lights], units, instances)
        read.write(self._scene)
        self._linked_instances = instances if read.linked else None
        domes = [read_dome(tree.prims[node], tree.world[node]) for node in nodes if tree.kinds[node] == DOME]
        present = [dome for dome in domes if dome is not None]
        if present != self._domes:
            self._domes = present
            self._scene.dome = self._dome_builder.build(present)
            self._scene.touch("dome")
