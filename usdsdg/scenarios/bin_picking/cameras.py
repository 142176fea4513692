"""Cameras above the bin: each by itself, or all of a rig as one."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from pxr import Gf, Usd, UsdGeom

from usdsdg.calibration.calibration import author_calibration
from usdsdg.calibration.rig import author_mount
from usdsdg.scenarios.bin_picking.bin import BinSize
from usdsdg.scenarios.bin_picking.config import BinCameras
from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.shared.lenses import DEFAULT_SIZE, author_field_of_view
from usdsdg.scenarios.shared.sections import mounts_of
from usdsdg.stage.cameras.camera_view import CameraView, read_camera
from usdsdg.stage.poses.look_at import author_look_at
from usdsdg.stage.poses.xform_ops import author_pose

# Nearest and farthest distance that is seen, in distances of the camera from the bin.
_CLIPPING = (0.001, 1000.0)
# Cameras aim at most this far from the middle of the bin, in its radii.
_AIM = 0.12


@dataclass(frozen=True)
class Station:
    """A prim that is placed and aimed: a camera, or a rig whose first camera is aimed."""

    prim: Usd.Prim
    view: CameraView  # of the camera that is aimed


@dataclass(frozen=True)
class BinCamerasOnStage:
    """Cameras with the sizes of their pictures, and what is moved."""

    cameras: list[Usd.Prim]
    sizes: list[tuple[int, int]]
    stations: list[Station]

    def randomize(self, draws: Draws, frame: int, size: BinSize, config: BinCameras) -> None:
        """Place each camera or rig above the bin, at a distance from which the bin has the size that is wanted."""
        for number, station in enumerate(self.stations):
            generator = draws.generator(f"camera/{number}", frame)
            # Evenly over the cap between the two tilts.
            low, high = (math.cos(math.radians(each)) for each in config.tilt)
            height = generator.uniform(high, low) if low > high else low
            turn = generator.uniform(0.0, 2.0 * math.pi)
            wanted = config.bin_in_image[0] * (config.bin_in_image[1] / config.bin_in_image[0]) ** generator.random()
            distance = size.radius / math.tan(_half_angle(station.view) * min(wanted, 1.0)) / max(wanted, 1.0)
            across = math.sqrt(max(1.0 - height * height, 0.0))
            middle = np.array((0.0, 0.0, size.height / 3.0))
            eye = middle + distance * np.array((across * math.cos(turn), across * math.sin(turn), height))
            aim = middle + generator.uniform(-_AIM, _AIM, 3) * size.radius
            up = (math.cos(roll := generator.uniform(0.0, 2.0 * math.pi)), math.sin(roll), 0.0)
            author_pose(station.prim, translate=eye.tolist())
            author_look_at(station.prim, Gf.Vec3d(*aim.tolist()), Gf.Vec3d(*up))


def add_cameras(
    stage: Usd.Stage, config: BinCameras, resolution: tuple[int, int] | None, scale: float
) -> BinCamerasOnStage:
    """Create the cameras below /World/Cameras; `scale` is the size of the bin, which decides what is too near."""
    mounts = mounts_of(config)
    cameras, stations, sizes = [], [], []
    if len(mounts) > 1:
        rig = stage.DefinePrim("/World/Cameras/Rig", "Xform")
        cameras = [author_mount(stage, str(rig.GetPath()), mount) for mount in mounts]
        sizes = [resolution or mount.calibration.size for mount in mounts]
        stations = [Station(rig, read_camera(stage, cameras[0].GetPath(), sizes[0]))]
    else:
        size = resolution or (mounts[0].calibration.size if mounts else DEFAULT_SIZE)
        for number in range(config.count):
            camera = UsdGeom.Camera.Define(stage, f"/World/Cameras/Camera_{number}")
            if mounts:
                author_calibration(camera.GetPrim(), mounts[0].calibration)
            else:
                author_field_of_view(camera, config.field_of_view)
            cameras.append(camera.GetPrim())
            sizes.append(size)
            stations.append(Station(camera.GetPrim(), read_camera(stage, camera.GetPath(), size)))
    for prim in cameras:
        UsdGeom.Camera(prim).CreateClippingRangeAttr(Gf.Vec2f(*(each * scale for each in _CLIPPING)))
    return BinCamerasOnStage(cameras, sizes, stations)


def _half_angle(view: CameraView) -> float:
    """Return the angle from the middle of a picture to the nearest edge [radians]."""
    pixels = [(view.width / 2.0, view.height / 2.0), (view.width / 2.0, 0.0), (0.0, view.height / 2.0)]
    _, rays = view.rays(np.array(pixels))
    angles = [math.acos(float(np.clip(rays[0] @ ray, -1.0, 1.0))) for ray in rays[1:] if np.isfinite(ray).all()]
    return min([*angles, math.radians(80.0)])
