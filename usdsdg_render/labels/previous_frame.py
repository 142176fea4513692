"""What each camera saw before: the past that motion vectors count from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import warp as wp

from usdsdg_render.device.camera import camera_array
from usdsdg_render.kernels.labels.aov import Past, Was
from usdsdg_render.scene.scene import Prototype, Scene
from usdsdg_render.scene.struct_rows import records, uploaded

if TYPE_CHECKING:
    from usdsdg.stage.cameras.camera_view import CameraView


class _Moment(NamedTuple):
    """Where all instances were, in what shape."""

    paths: tuple[str, ...]
    matrices: np.ndarray  # (instances, 4, 4) local to world
    prototypes: tuple[Prototype, ...]


class _Look(NamedTuple):
    """A camera's view at some moment."""

    view: CameraView
    moment: _Moment


class _Looks(NamedTuple):
    """The last two of one camera, and after which sync the later one was."""

    before: _Look
    last: _Look
    sync: int


_NOTHING = _Moment((), np.zeros((0, 4, 4)), ())


class History:
    """Per camera and size of its picture: what it saw when motion vectors were last asked for.

    Asked again where neither the scene was synced nor the camera has moved, the answer is the same.
    """

    def __init__(self, device: str) -> None:
        self.device = device
        self._looks: dict[tuple[str, int, int], _Looks] = {}
        self._sync = 0
        self._now: _Moment | None = None
        # What the last `Past` points to, by the shapes before and now.
        self._corners: dict[tuple[int, int], wp.array] = {}

    def advance(self) -> None:
        """The scene was synced: what cameras saw until now is their past."""
        self._sync += 1
        self._now = None

    def past_of(self, views: Sequence[CameraView], scene: Scene) -> Past:
        """The past of cameras in the order of the present instances; the present where there is none."""
        looks = [self._past_look(view) for view in views]
        moments = {id(look.moment): look.moment for look in looks}
        rows = {key: row for row, key in enumerate(moments)}
        past = Past()
        past.cameras = camera_array([look.view for look in looks], self.device)
        past.moments = wp.array([rows[id(look.moment)] for look in looks], dtype=wp.int32, device=self.device)
        self._corners = {}
        places = records(Was, len(moments) * len(scene.instances.paths)).reshape(len(moments), -1)
        for row, moment in zip(places, moments.values(), strict=True):
            self._place(row, moment, scene)
        past.places = uploaded(places, Was, self.device)
        return past

    def have_lens(self, views: Sequence[CameraView]) -> bool:
        """Whether one of these cameras is no pinhole, or was none."""
        return any(view.lens is not None or self._past_look(view).view.lens is not None for view in views)

    def remember(self, views: Sequence[CameraView], scene: Scene) -> None:
        """Make the present the past of these cameras, for when they or the scene have moved."""
        if self._now is None:
            instances = scene.instances
            prototypes = tuple(scene.prototypes[index] for index in instances.prototype.tolist())
            self._now = _Moment(instances.paths, instances.local_to_world.copy(), prototypes)
        for view in views:
            self._looks[_key(view)] = _Looks(self._past_look(view), _Look(view, self._now), self._sync)

    def _past_look(self, view: CameraView) -> _Look:
        looks = self._looks.get(_key(view))
        if looks is None:
            return _Look(view, _NOTHING)
        again = looks.sync == self._sync and np.array_equal(looks.last.view.local_to_world, view.local_to_world)
        return looks.before if again else looks.last

    def _place(self, rows: np.ndarray, moment: _Moment, scene: Scene) -> None:
        """Fill (instances,) records of Was."""
        instances = scene.instances
        matrices = instances.local_to_world.copy()
        here, there = _shared(instances.paths, moment.paths)
        matrices[here] = moment.matrices[there]
        rows["known"][here] = 1
        rows["local_to_world"] = matrices[:, :3, :3].transpose(0, 2, 1)
        rows["world_origin"] = matrices[:, 3, :3]
        shapes = [scene.prototypes[index] for index in instances.prototype.tolist()]
        changed = [(k, before) for k, before in zip(here, there) if shapes[k] is not moment.prototypes[before]]
        for k, before in changed:
            rows["corners"][k] = self._past_corners(moment.prototypes[before], shapes[k])

    def _past_corners(self, before: Prototype, now: Prototype) -> int:
        """The address of the corners of a shape that had other points; 0 if it had other triangles."""
        key = id(before), id(now)
        if key not in self._corners:
            same = np.array_equal(before.triangles, now.triangles)
            corners = before.points[before.triangles].reshape(-1, 3) if same else np.zeros((0, 3), np.float32)
            self._corners[key] = wp.array(corners, dtype=wp.vec3, device=self.device)
        held = self._corners[key]
        return int(held.ptr or 0)


def _shared(now: tuple[str, ...], before: tuple[str, ...]) -> tuple[Sequence[int], Sequence[int]]:
    """Where the paths that are in both stand, in one and in the other."""
    if now == before:
        return range(len(now)), range(len(now))
    places = {path: k for k, path in enumerate(before)}
    both = [(k, places[path]) for k, path in enumerate(now) if path in places]
    return [k for k, _ in both], [k for _, k in both]


def _key(view: CameraView) -> tuple[str, int, int]:
    return view.prim_path, view.width, view.height
