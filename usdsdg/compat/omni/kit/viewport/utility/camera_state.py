"""`omni.kit.viewport.utility.camera_state`: where the camera of a viewport is, and what it looks at."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.compat.omni.kit.viewport.utility import Viewport, get_active_viewport
from usdsdg.compat.wrappers.cameras import aim, camera_at, editable_layer
from usdsdg.stage.poses.transforms import local_to_world
from usdsdg.stage.time_code import current_time

__all__ = ["ViewportCameraState"]

# In the application it says where, in the camera, the point is that a person turns the view about.
_CENTER_OF_INTEREST = "omni:kit:centerOfInterest"


class ViewportCameraState:
    """The camera at a path, by default that of the viewport; positions are in the world [stage units]."""

    def __init__(
        self,
        camera_path: Sdf.Path | str | None = None,
        viewport: Viewport | None = None,
        time: Usd.TimeCode | None = None,
        force_create: bool = False,
    ) -> None:
        """
        Raises:
            BadPrim: there is no such camera.
        """
        seen = viewport or get_active_viewport()
        self._camera = camera_at(str(camera_path or seen.camera_path))
        self._time = time

    @property
    def usd_camera(self) -> UsdGeom.Camera:
        """The camera."""
        return UsdGeom.Camera(self._camera)

    @property
    def position_world(self) -> Gf.Vec3d:
        """Where the camera is."""
        return self._to_world().ExtractTranslation()

    @property
    def target_world(self) -> Gf.Vec3d:
        """The point that `set_target_world` was given, moved with the camera; else one ahead, a unit away."""
        center = self._camera.GetAttribute(_CENTER_OF_INTEREST)
        local = center.Get() if center and center.HasAuthoredValue() else Gf.Vec3d(0, 0, -1)
        return self._to_world().Transform(Gf.Vec3d(local))

    def set_position_world(self, world_position: Sequence[float], rotate: bool) -> None:
        """Move the camera; with `rotate` it looks at its target from there, without it the view is moved along."""
        target = self.target_world
        aim(self._camera, list(world_position), list(target) if rotate else None)
        if rotate:
            self._keep(target)

    def set_target_world(self, world_target: Sequence[float], rotate: bool) -> None:
        """Turn the camera to a point; without `rotate` it is moved along with its target instead."""
        target = Gf.Vec3d(*world_target)
        if rotate:
            aim(self._camera, None, list(target))
        else:
            aim(self._camera, list(self.position_world + target - self.target_world))
        self._keep(target)

    def _keep(self, target: Gf.Vec3d) -> None:
        stage = self._camera.GetStage()
        with Usd.EditContext(stage, editable_layer(self._camera)):
            center = self._camera.CreateAttribute(_CENTER_OF_INTEREST, Sdf.ValueTypeNames.Vector3d, True)
            center.Set(self._to_world().GetInverse().Transform(target))

    def _to_world(self) -> Gf.Matrix4d:
        return local_to_world(self._camera, current_time() if self._time is None else self._time)
