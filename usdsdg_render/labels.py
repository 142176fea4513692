"""The label pass on the host: allocate what is asked for, launch, remember the past for motion vectors."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import warp as wp

from usdsdg_render.aov import AMBIENT_REACH, AOVS, MATERIAL_AOVS, check_names
from usdsdg_render.camera import camera_record
from usdsdg_render.device import DeviceScene
from usdsdg_render.kernels.ambient_aov import label_ambient
from usdsdg_render.kernels.aov import AovArrays, Past, label_pixels
from usdsdg_render.kernels.camera import BAND
from usdsdg_render.kernels.curved_motion import label_curved_motion
from usdsdg_render.kernels.lens import NONE
from usdsdg_render.kernels.material_aov import MaterialArrays, label_materials
from usdsdg_render.parallel import launch_rows
from usdsdg_render.scene import Prototype, Scene

if TYPE_CHECKING:
    from usdsdg.stage.cameras import CameraView

_DTYPES = {(np.int32, ()): wp.int32, (np.float32, ()): wp.float32}
_DTYPES |= {(np.float32, (2,)): wp.vec2, (np.float32, (3,)): wp.vec3}

_OPENNESS = frozenset({"ambient_occlusion"})


class _Seen(NamedTuple):
    """What a camera saw, and from where."""

    view: CameraView
    matrices: dict[str, np.ndarray]  # local to world, by path of the instance
    prototypes: dict[str, Prototype]


class History:
    """Per camera: its view, and where all instances were in what shape, when motion vectors were last asked for."""

    def __init__(self, device: str) -> None:
        self.device = device
        self._seen: dict[str, _Seen] = {}
        self._corners: list[wp.array] = []  # what the last `Past` points to

    def past_of(self, view: CameraView, scene: Scene) -> Past:
        """The past of a camera in the order of the present instances; the present where there is none."""
        instances = scene.instances
        old = self._seen.get(view.prim_path, _Seen(view, {}, {}))
        past = Past()
        past.camera = camera_record(old.view)
        known = np.array([path in old.matrices for path in instances.paths], np.int32)
        matrices = np.array(
            [old.matrices.get(path, now) for path, now in zip(instances.paths, instances.local_to_world, strict=True)],
            np.float32,
        ).reshape(-1, 4, 4)
        past.known = wp.array(known, dtype=wp.int32, device=self.device)
        past.local_to_world = wp.array(
            np.ascontiguousarray(matrices[:, :3, :3].transpose(0, 2, 1)), dtype=wp.mat33, device=self.device
        )
        past.world_origin = wp.array(np.ascontiguousarray(matrices[:, 3, :3]), dtype=wp.vec3, device=self.device)
        past.corners = wp.array(self._past_corners(old, scene), dtype=wp.uint64, device=self.device)
        return past

    def _past_corners(self, old: _Seen, scene: Scene) -> np.ndarray:
        """(instances,) uint64 addresses of the corners of those that had another shape of the same triangles."""
        uploaded: dict[tuple[int, int], wp.array | None] = {}
        addresses = np.zeros(len(scene.instances.paths), np.uint64)
        for k, (path, index) in enumerate(zip(scene.instances.paths, scene.instances.prototype, strict=True)):
            before, now = old.prototypes.get(path), scene.prototypes[index]
            if before is None or before is now:
                continue
            key = id(before), id(now)
            if key not in uploaded:
                same = np.array_equal(before.triangles, now.triangles)
                corners = before.points[before.triangles].reshape(-1, 3) if same else None
                uploaded[key] = None if corners is None else wp.array(corners, dtype=wp.vec3, device=self.device)
            held = uploaded[key]
            addresses[k] = 0 if held is None else held.ptr
        self._corners = [each for each in uploaded.values() if each is not None]
        return addresses

    def remember(self, view: CameraView, scene: Scene) -> None:
        """Make the present the past of this camera."""
        instances = scene.instances
        prototypes = [scene.prototypes[index] for index in instances.prototype]
        self._seen[view.prim_path] = _Seen(
            view,
            dict(zip(instances.paths, instances.local_to_world.copy(), strict=True)),
            dict(zip(instances.paths, prototypes, strict=True)),
        )


def render(
    device_scene: DeviceScene,
    history: History,
    scene: Scene,
    view: CameraView,
    aovs: Collection[str],
    *,
    mode: int,
    threads: int | None,
) -> dict[str, np.ndarray]:
    """See `WarpRenderer.labels`; `mode` as for kernels.visibility.closest."""
    names = check_names(aovs)
    device = device_scene.device
    camera = camera_record(view)
    shape = (view.height, view.width)
    made = {
        name: wp.zeros(shape, dtype=_DTYPES[AOVS[name].dtype, AOVS[name].channels], device=device) for name in names
    }
    wants_motion = "motion_vectors" in names
    past = history.past_of(view, scene) if wants_motion else Past()
    curved_motion = {"motion_vectors"} if wants_motion and camera.lens_kind + past.camera.lens_kind != NONE else set()
    out, of_material = AovArrays(), MaterialArrays()
    for name in made.keys() - _OPENNESS - curved_motion:
        setattr(of_material if name in MATERIAL_AOVS else out, name, made[name])
    inputs = [device_scene.tables, camera, past, float(view.meters_per_unit), mode]
    if not (MATERIAL_AOVS | _OPENNESS).issuperset(names):
        bands = (-(-view.height // BAND), view.width, BAND)
        launch_rows(label_pixels, bands, inputs, [out], device=device, threads=threads, band_rows=4)
    if not MATERIAL_AOVS.isdisjoint(names):
        inputs = [device_scene.tables, camera, mode]
        launch_rows(label_materials, shape, inputs, [of_material], device=device, threads=threads, band_rows=16)
    for name in _OPENNESS.intersection(names):
        inputs = [device_scene.tables, camera, AMBIENT_REACH / float(view.meters_per_unit), mode]
        launch_rows(label_ambient, shape, inputs, [made[name]], device=device, threads=threads)
    for name in curved_motion:
        inputs = [device_scene.tables, camera, past, mode]
        launch_rows(label_curved_motion, shape, inputs, [made[name]], device=device, threads=threads, band_rows=16)
    if wants_motion:
        history.remember(view, scene)
    return {name: array.numpy() for name, array in made.items()}
