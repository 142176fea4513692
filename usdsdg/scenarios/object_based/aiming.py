"""Cameras that are aimed again after the push, so that their images show what they look at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdLux

from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.gprims import rows_below
from usdsdg.scenarios.object_based.cameras import CLEARANCE, Cameras, drawn_aim
from usdsdg.scenarios.object_based.config import ObjectBasedConfig
from usdsdg.session import engines
from usdsdg.session.timeline import stage_time
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg.stage.poses.xform_ops import author_pose

MAX_ATTEMPTS = 24
# The target should cover a fraction of the middle of the image; BORDER of each side of the image is not its middle.
LEAST, MOST = 0.04, 0.6
BORDER = 0.2
# While the image is exposed, targets should move by at most this fraction of their distance, or they are streaks.
FASTEST = 0.04
# Width of the image in which its pixels are counted.
WIDTH = 160


@dataclass(frozen=True)
class _Aim:
    """A camera's pose, and how its target looks from there."""

    position: Gf.Vec3d
    orientation: Gf.Quatf
    covered: float  # fraction of the middle of the image
    travel: float  # while the image is exposed, as a fraction of the distance

    @property
    def is_good(self) -> bool:
        """Whether the target is large enough, not all that can be seen, and no streak."""
        return LEAST <= self.covered <= MOST and self.travel <= FASTEST

    @property
    def score(self) -> float:
        """How near to good it is: too small is better the larger, too large the smaller, too fast the slower."""
        size = self.covered if self.covered <= MOST else MOST * LEAST / self.covered
        return size * min(1.0, FASTEST / max(self.travel, FASTEST))


class Aiming:
    """Aims cameras again, each from where it was placed and space around it was cleared."""

    def __init__(self, cameras: Cameras, targets: list[Usd.Prim], config: ObjectBasedConfig, draws: Draws) -> None:
        self._cameras, self._targets, self._config, self._draws = cameras.prims, targets, config, draws
        self._places: list[Gf.Vec3d] = []
        self._lamps: list[Usd.Prim] | None = None
        self._lights: list[tuple[Gf.Vec3d, float]] = []

    def remember_places(self) -> None:
        """Remember where the cameras are, around which space has been cleared."""
        self._places = [Gf.Vec3d(camera.GetAttribute("xformOp:translate").Get()) for camera in self._cameras]

    def aim(self, stage: Usd.Stage, frame: int, *, exposure: float = 0.0) -> None:
        """Aim every camera at a random target, seen from its own place at a distance within the range.

        exposure: seconds for which the image of this frame is exposed.

        Poses are drawn until the target covers enough of the middle of the image and not all of it, and is no streak;
        the best one is taken if none is.
        """
        engines.renderer().sync(stage_time(stage))
        if self._lamps is None:  # randomizers make theirs when they first run, before the first aim, and no more later
            self._lamps = [prim for prim in stage.Traverse() if prim.IsA(UsdLux.SphereLight)]
        self._lights = _spheres(self._lamps)
        for number, (camera, place) in enumerate(zip(self._cameras, self._places, strict=True)):
            best = None
            for attempt in range(MAX_ATTEMPTS):
                aim = self._drawn(camera, place, f"camera/{number}/again/{attempt}", frame, exposure)
                if aim is not None and (best is None or aim.score > best.score):
                    best = aim
                if aim is not None and aim.is_good:
                    break
            if best is not None:
                author_pose(camera, translate=best.position, orient=best.orientation)

    def _drawn(self, camera: Usd.Prim, place: Gf.Vec3d, purpose: str, frame: int, exposure: float) -> _Aim | None:
        """Draw a pose and look through the camera there; None where something is in the way."""
        target, point, distance = drawn_aim(purpose, frame, self._targets, self._config, self._draws)
        away = (place - point).GetNormalized()
        position = point + away * distance
        if engines.physics().overlap_sphere(CLEARANCE, position) or _is_dazzled(position, point, self._lights):
            return None
        orientation = Gf.Quatf(Gf.Rotation(Gf.Vec3d(0, 0, -1), -away).GetQuat())
        author_pose(camera, translate=position, orient=orientation)
        travel = _speed(target) * exposure / distance
        return _Aim(position, orientation, _covered(camera, target, self._config.resolution), travel)


def _speed(target: Usd.Prim) -> float:
    """Return the speed of a body [stage units per second]."""
    velocity = target.GetAttribute("physics:velocity").Get()
    return 0.0 if velocity is None else Gf.Vec3f(velocity).GetLength()


def _spheres(lights: Sequence[Usd.Prim]) -> list[tuple[Gf.Vec3d, float]]:
    """Return center and radius of sphere lights, which images show as white balls and labels do not."""
    cache, found = UsdGeom.XformCache(), []
    for prim in lights:
        pose = cache.GetLocalToWorldTransform(prim)
        scale = max(Gf.Vec3d(*pose.GetRow3(axis)).GetLength() for axis in range(3))
        found.append((pose.ExtractTranslation(), UsdLux.SphereLight(prim).GetRadiusAttr().Get() * scale))
    return found


def _is_dazzled(eye: Gf.Vec3d, point: Gf.Vec3d, lights: Sequence[tuple[Gf.Vec3d, float]]) -> bool:
    """Return whether a light is between an eye and a point, or around one of them."""
    ahead = point - eye
    for center, radius in lights:
        along = min(max(Gf.Dot(center - eye, ahead) / max(Gf.Dot(ahead, ahead), 1e-12), 0.0), 1.0)
        if (eye + ahead * along - center).GetLength() < radius:
            return True
    return False


def _covered(camera: Usd.Prim, target: Usd.Prim, resolution: tuple[int, int]) -> float:
    """Return the fraction of the middle of the camera's image that shows a target."""
    renderer = engines.renderer()
    size = (WIDTH, max(1, round(WIDTH * resolution[1] / resolution[0])))
    view = read_camera(camera.GetStage(), camera.GetPath(), size, time=renderer.time)
    (found,) = renderer.labels_of([view], ("instance",))
    mine = np.zeros(len(renderer.gprims) + 1, bool)  # where nothing is hit the index is -1
    mine[rows_below(renderer.gprims, [target])[0]] = True
    shown = mine[found["instance"]]
    top, left = (round(BORDER * each) for each in shown.shape)
    return float(shown[top : shown.shape[0] - top, left : shown.shape[1] - left].mean())
