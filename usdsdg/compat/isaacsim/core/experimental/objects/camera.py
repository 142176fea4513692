"""Cameras. Focal lengths and apertures are stage units, of which USD has tenths."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Gf, UsdGeom

from usdsdg.compat.isaacsim.core.experimental.objects.typed_prims import TypedPrims
from usdsdg.compat.wrappers.arrays import column, names, rows

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values

_TENTHS = 10.0  # attributes of lenses are tenths of a stage unit


class Camera(TypedPrims):
    """Cameras, which are defined where there is no prim yet."""

    _schema = UsdGeom.Camera

    @property
    def cameras(self) -> list[UsdGeom.Camera]:
        """Return each prim as its schema."""
        return self._schemas()

    # --- lens ---
    def set_focal_lengths(self, focal_lengths: Values, *, indices: Indices = None) -> None:
        """Set focal lengths [stage units] (N, 1)."""
        self._set_lengths("FocalLength", focal_lengths, indices)

    def get_focal_lengths(self, *, indices: Indices = None) -> wp.array:
        """Return focal lengths [stage units] (N, 1)."""
        return self._lengths("FocalLength", indices)

    def set_focus_distances(self, focus_distances: Values, *, indices: Indices = None) -> None:
        """Set how far away is sharp [stage units] (N, 1)."""
        self._set_number("FocusDistance", focus_distances, indices)

    def get_focus_distances(self, *, indices: Indices = None) -> wp.array:
        """Return how far away is sharp [stage units] (N, 1)."""
        return self._number("FocusDistance", indices)

    def set_fstops(self, fstops: Values, *, indices: Indices = None) -> None:
        """Set f-stops (N, 1); 0 is sharp everywhere."""
        self._set_number("FStop", fstops, indices)

    def get_fstops(self, *, indices: Indices = None) -> wp.array:
        """Return f-stops (N, 1); 0 is sharp everywhere."""
        return self._number("FStop", indices)

    def set_apertures(
        self,
        horizontal_apertures: Values | None = None,
        vertical_apertures: Values | None = None,
        *,
        indices: Indices = None,
    ) -> None:
        """Set widths and heights of the sensors [stage units] (N, 1); None leaves them.

        Raises:
            AssertionError: neither is given.
        """
        _check_given("set_apertures", horizontal_apertures, vertical_apertures)
        self._set_lengths("HorizontalAperture", horizontal_apertures, indices)
        self._set_lengths("VerticalAperture", vertical_apertures, indices)

    def get_apertures(self, *, indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return widths and heights of the sensors [stage units], each (N, 1)."""
        return self._lengths("HorizontalAperture", indices), self._lengths("VerticalAperture", indices)

    def set_aperture_offsets(
        self,
        horizontal_offsets: Values | None = None,
        vertical_offsets: Values | None = None,
        *,
        indices: Indices = None,
    ) -> None:
        """Set offsets of the sensors [stage units] (N, 1); None leaves them.

        Raises:
            AssertionError: neither is given.
        """
        _check_given("set_aperture_offsets", horizontal_offsets, vertical_offsets)
        self._set_lengths("HorizontalApertureOffset", horizontal_offsets, indices)
        self._set_lengths("VerticalApertureOffset", vertical_offsets, indices)

    def get_aperture_offsets(self, *, indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return offsets of the sensors [stage units], each (N, 1)."""
        return self._lengths("HorizontalApertureOffset", indices), self._lengths("VerticalApertureOffset", indices)

    def enforce_square_pixels(
        self, resolutions: Values, *, modes: str | Sequence[str] = "horizontal", indices: Indices = None
    ) -> None:
        """Give sensors the shape of images of (height, width), or of each (N, 2).

        With the mode "horizontal" the width stays and the height follows, with "vertical" the other way round.

        Raises:
            ValueError: there is no such mode.
        """
        cameras = self._schemas(indices)
        shapes = rows(resolutions, 2, len(cameras))
        for camera, (height, width), mode in zip(cameras, shapes, names(modes, len(cameras)), strict=True):
            if mode == "horizontal":
                camera.GetVerticalApertureAttr().Set(camera.GetHorizontalApertureAttr().Get() * float(height / width))
            elif mode == "vertical":
                camera.GetHorizontalApertureAttr().Set(camera.GetVerticalApertureAttr().Get() * float(width / height))
            else:
                raise ValueError(f"there is no mode {mode!r}; give 'horizontal' or 'vertical'")

    # --- projection, range, shutter ---
    def set_projections(self, projections: str | Sequence[str], *, indices: Indices = None) -> None:
        """Set the kind of each: "perspective" or "orthographic"."""
        self._set_text("Projection", projections, indices)

    def get_projections(self, *, indices: Indices = None) -> list[str]:
        """Return the kind of each: "perspective" or "orthographic"."""
        return [camera.GetProjectionAttr().Get() for camera in self._schemas(indices)]

    def set_stereo_roles(self, roles: str | Sequence[str], *, indices: Indices = None) -> None:
        """Set which eye each is: "mono", "left" or "right"."""
        self._set_text("StereoRole", roles, indices)

    def get_stereo_roles(self, *, indices: Indices = None) -> list[str]:
        """Return which eye each is: "mono", "left" or "right"."""
        return [camera.GetStereoRoleAttr().Get() for camera in self._schemas(indices)]

    def set_clipping_ranges(
        self, near_distances: Values | None = None, far_distances: Values | None = None, *, indices: Indices = None
    ) -> None:
        """Set from where and to where is seen [stage units] (N, 1); None leaves it.

        Raises:
            AssertionError: neither is given.
        """
        _check_given("set_clipping_ranges", near_distances, far_distances)
        cameras = self._schemas(indices)
        for end, values in enumerate((near_distances, far_distances)):
            for camera, value in zip(cameras, [] if values is None else column(values, len(cameras)), strict=False):
                both = list(camera.GetClippingRangeAttr().Get())
                both[end] = float(value)
                camera.GetClippingRangeAttr().Set(Gf.Vec2f(*both))

    def get_clipping_ranges(self, *, indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return from where and to where is seen [stage units], each (N, 1)."""
        ranges = np.array([camera.GetClippingRangeAttr().Get() for camera in self._schemas(indices)], np.float32)
        near, far = ranges.reshape(-1, 2).T
        return self._warp(near.reshape(-1, 1)), self._warp(far.reshape(-1, 1))

    def set_shutter_times(
        self, open_times: Values | None = None, close_times: Values | None = None, *, indices: Indices = None
    ) -> None:
        """Set when shutters open and close [time codes from that of the frame] (N, 1); None leaves it.

        Raises:
            AssertionError: neither is given.
        """
        _check_given("set_shutter_times", open_times, close_times)
        if open_times is not None:
            self._set_number("ShutterOpen", open_times, indices)
        if close_times is not None:
            self._set_number("ShutterClose", close_times, indices)

    def get_shutter_times(self, *, indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return when shutters open and close [time codes from that of the frame], each (N, 1)."""
        return self._number("ShutterOpen", indices), self._number("ShutterClose", indices)

    # --- attributes in tenths ---
    def _set_lengths(self, name: str, values: Values | None, indices: Indices) -> None:
        if values is not None:
            count = len(self._schemas(indices))
            self._set_number(name, np.asarray(column(values, count), float) * _TENTHS, indices)

    def _lengths(self, name: str, indices: Indices) -> wp.array:
        return self._warp(self._number(name, indices).numpy() / np.float32(_TENTHS))


def _check_given(caller: str, *values: Any) -> None:
    assert any(each is not None for each in values), f"{caller}: give at least one of both"
