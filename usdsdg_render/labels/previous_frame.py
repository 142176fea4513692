"""The previous frame of each camera, to which motion vectors are relative."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import warp as wp

from usdsdg_render.device.camera import camera_array
from usdsdg_render.kernels.labels.motion import PreviousFrame, PreviousInstance
from usdsdg_render.scene.scene import Prototype, Scene
from usdsdg_render.scene.struct_rows import records, uploaded

if TYPE_CHECKING:
    from usdsdg.stage.cameras.camera_view import CameraView


class _Poses(NamedTuple):
    """Poses and shapes of all instances in one frame."""

    keys: tuple[str, ...]
    matrices: np.ndarray  # (instances, 4, 4) local to world
    prototypes: tuple[Prototype, ...]


class _Frame(NamedTuple):
    """A camera and the instances in one frame."""

    view: CameraView
    poses: _Poses


class _LastFrames(NamedTuple):
    """The last two frames of one camera, and the number of the sync before the later one."""

    previous: _Frame
    last: _Frame
    sync: int


_NO_POSES = _Poses((), np.zeros((0, 4, 4)), ())


class PreviousFrames:
    """The frame in which motion vectors were last rendered, per camera and image size.

    If they are rendered again without a sync and at the same pose of the camera, the result is the same.
    """

    def __init__(self, device: str) -> None:
        self.device = device
        self._frames: dict[tuple[str, int, int], _LastFrames] = {}
        self._sync = 0
        self._poses: _Poses | None = None  # of the current frame, once a camera asked for them
        # Keeps alive what the last `PreviousFrame` points to, by the ids of the previous and the current prototype.
        self._corners: dict[tuple[int, int], wp.array] = {}

    def advance(self) -> None:
        """Begin a frame, after a sync of the scene."""
        self._sync += 1
        self._poses = None

    def of(self, views: Sequence[CameraView], scene: Scene) -> PreviousFrame:
        """Return the previous frames of cameras, with instances in current order; the current one if there is none."""
        frames = [self._previous(view) for view in views]
        poses = {id(frame.poses): frame.poses for frame in frames}
        rows = {key: row for row, key in enumerate(poses)}
        record = PreviousFrame()
        record.cameras = camera_array([frame.view for frame in frames], self.device)
        record.frames = wp.array([rows[id(frame.poses)] for frame in frames], dtype=wp.int32, device=self.device)
        self._corners = {}
        instances = records(PreviousInstance, len(poses) * len(scene.instances.paths)).reshape(len(poses), -1)
        for row, each in zip(instances, poses.values(), strict=True):
            self._fill(row, each, scene)
        record.instances = uploaded(instances, PreviousInstance, self.device)
        return record

    def have_lens(self, views: Sequence[CameraView]) -> bool:
        """Return whether any camera has a lens model now, or had one in its previous frame."""
        return any(view.lens is not None or self._previous(view).view.lens is not None for view in views)

    def remember(self, views: Sequence[CameraView], scene: Scene) -> None:
        """Store the current frame of these cameras, which becomes the previous one after a sync or camera motion."""
        if self._poses is None:
            instances = scene.instances
            prototypes = tuple(scene.prototypes[index] for index in instances.prototype.tolist())
            self._poses = _Poses(instances.keys, instances.local_to_world.copy(), prototypes)
        for view in views:
            self._frames[_key(view)] = _LastFrames(self._previous(view), _Frame(view, self._poses), self._sync)

    def _previous(self, view: CameraView) -> _Frame:
        frames = self._frames.get(_key(view))
        if frames is None:
            return _Frame(view, _NO_POSES)
        again = frames.sync == self._sync and np.array_equal(frames.last.view.local_to_world, view.local_to_world)
        return frames.previous if again else frames.last

    def _fill(self, rows: np.ndarray, previous: _Poses, scene: Scene) -> None:
        """Fill (instances,) records of `PreviousInstance`."""
        instances = scene.instances
        matrices = instances.local_to_world.copy()
        rows_now, rows_before = _shared_rows(instances.keys, previous.keys)
        matrices[rows_now] = previous.matrices[rows_before]
        rows["known"][rows_now] = 1
        rows["local_to_world"] = matrices[:, :3, :3].transpose(0, 2, 1)
        rows["world_origin"] = matrices[:, 3, :3]
        shapes = [scene.prototypes[index] for index in instances.prototype.tolist()]
        changed = [
            (k, before) for k, before in zip(rows_now, rows_before) if shapes[k] is not previous.prototypes[before]
        ]
        for k, before in changed:
            rows["corners"][k] = self._previous_corners(previous.prototypes[before], shapes[k])

    def _previous_corners(self, before: Prototype, now: Prototype) -> int:
        """Return the address of triangle corners in the previous frame; 0 if the mesh had other triangles."""
        key = id(before), id(now)
        if key not in self._corners:
            same = np.array_equal(before.triangles, now.triangles)
            corners = before.points[before.triangles].reshape(-1, 3) if same else np.zeros((0, 3), np.float32)
            self._corners[key] = wp.array(corners, dtype=wp.vec3, device=self.device)
        held = self._corners[key]
        return int(held.ptr or 0)


def _shared_rows(now: tuple[str, ...], before: tuple[str, ...]) -> tuple[Sequence[int], Sequence[int]]:
    """Return the indices of the keys that are in both, in `now` and in `before`."""
    if now == before:
        return range(len(now)), range(len(now))
    positions = {key: k for k, key in enumerate(before)}
    both = [(k, positions[key]) for k, key in enumerate(now) if key in positions]
    return [k for k, _ in both], [k for _, k in both]


def _key(view: CameraView) -> tuple[str, int, int]:
    return view.prim_path, view.width, view.height
