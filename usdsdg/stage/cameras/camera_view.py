"""The record of a camera: everything of a UsdGeom.Camera that an image depends on."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom

from usdsdg import errors
from usdsdg.stage.cameras.ignored_attributes import warn_of_clipping_planes
from usdsdg.stage.cameras.lens import Lens
from usdsdg.stage.cameras.lens_attributes import LensParameters, read_lens, undocumented_attributes
from usdsdg.stage.cameras.lenses import LENS_MODELS, LINEAR_PROJECTIONS, make_lens
from usdsdg.stage.paths import prim_at
from usdsdg.stage.poses.transforms import as_array, local_to_world, meters_per_unit
from usdsdg.stage.usd_errors import reason

# Apertures are in tenths of a stage unit.
_APERTURE_UNIT = 0.1
# Cosine of the angle between two axes of a camera up to which they are perpendicular: rotations in single precision
# below several prims are that much off.
_MOST_SHEAR = 1e-5

_FIELDS = {
    "focalLength": "focal_length",
    "horizontalAperture": "horizontal_aperture",
    "verticalAperture": "vertical_aperture",
    "horizontalApertureOffset": "horizontal_aperture_offset",
    "verticalApertureOffset": "vertical_aperture_offset",
    "fStop": "f_stop",
    "focusDistance": "focus_distance",
}


@dataclass(frozen=True, eq=False)
class CameraView:
    """A camera for images of one size. It looks along its -Z with +Y up.

    Focal length and apertures are in tenths of stage units; clipping range and focus distance in stage units.
    Pixels are square: the horizontal aperture spans the width, and the vertical one is reported but not used. This, and
    `fx` to `cy`, apply to pinhole and orthographic cameras; others have a `lens`. A view with a `margin` shows the same
    picture with so many columns more on its left and on its right, and so many rows more above and below it.
    """

    prim_path: str
    width: int
    height: int
    local_to_world: np.ndarray  # (4, 4) float64, row vectors
    focal_length: float = 50.0
    horizontal_aperture: float = 20.955
    vertical_aperture: float = 15.2908
    horizontal_aperture_offset: float = 0.0
    vertical_aperture_offset: float = 0.0
    clipping_range: tuple[float, float] = (1.0, 1000000.0)
    f_stop: float = 0.0
    focus_distance: float = 0.0
    projection_type: str = "pinhole"  # Replicator's name, whichever schema it is read from
    lens_parameters: LensParameters = field(default_factory=LensParameters)
    meters_per_unit: float = 1.0
    attributes: dict[str, Any] = field(default_factory=dict)  # all other camera attributes, by USD name
    margin: tuple[int, int] = (0, 0)  # columns, rows; `width` and `height` include them on both sides

    @cached_property
    def world_to_camera(self) -> np.ndarray:
        """(4, 4) float64: p_camera = p_world @ world_to_camera."""
        return np.linalg.inv(self.local_to_world)

    @cached_property
    def lens(self) -> Lens | None:
        """The lens model; None for pinhole and orthographic cameras.

        Raises:
            Unsupported: the projection is not known, or its calibration gives no image.
            AssetError: a texture of the lens is missing or unreadable.
        """
        try:
            lens = make_lens(
                self.projection_type,
                self.lens_parameters,
                self._picture,
                focal_length=self.focal_length,
                horizontal_aperture=self.horizontal_aperture,
                center=(self.cx - self.margin[0], self.cy - self.margin[1]),
                meters_per_unit=self.meters_per_unit,
            )
            return lens.widened(self.margin) if lens is not None and any(self.margin) else lens
        except (errors.Unsupported, errors.AssetError) as problem:
            raise type(problem)(f"{self.prim_path}: {problem}") from None

    @property
    def fx(self) -> float:
        """Focal length [pixels]; for an orthographic camera pixels per stage unit."""
        if self.projection_type == "orthographic":
            return self._picture[0] / (self.horizontal_aperture * _APERTURE_UNIT)
        return self._picture[0] * self.focal_length / self.horizontal_aperture

    @property
    def fy(self) -> float:
        """Equal to `fx`: pixels are square."""
        return self.fx

    @property
    def cx(self) -> float:
        """Column of the optical axis [pixels from the left edge]; pixel u has its center at u + 0.5."""
        across = self._picture[0] * (0.5 - self.horizontal_aperture_offset / self.horizontal_aperture)
        return self.margin[0] + across

    @property
    def cy(self) -> float:
        """Row of the optical axis [pixels from the top edge]."""
        width, height = self._picture
        return self.margin[1] + height * 0.5 + width * self.vertical_aperture_offset / self.horizontal_aperture

    @property
    def _picture(self) -> tuple[int, int]:
        """Width and height without the margins."""
        return self.width - 2 * self.margin[0], self.height - 2 * self.margin[1]

    def widened(self) -> "CameraView | None":
        """Return the view with margins as wide and as high as the picture; None if the lens sees all around.

        The pixels of the picture are the same.
        """
        if self.lens is not None and self.lens.is_panorama:
            return None
        size = self.width, self.height
        return replace(self, width=3 * size[0], height=3 * size[1], margin=size)

    @property
    def projection_matrix(self) -> np.ndarray:
        """Matrix (4, 4) from camera to clip space, row vectors, reversed Z: depth 1 at the near plane, 0 at the far.

        Raises:
            Unsupported: the projection is not linear.
        """
        self._require_linear("a projection matrix")
        near, far = self.clipping_range
        m = np.zeros((4, 4))
        m[0, 0] = 2.0 * self.fx / self.width
        m[1, 1] = 2.0 * self.fy / self.height
        shift = np.array([1.0 - 2.0 * self.cx / self.width, 2.0 * self.cy / self.height - 1.0])
        endless = np.isinf(far)  # then these are the limits
        if self.projection_type == "orthographic":
            m[2, 2], m[3, 2], m[3, 3] = 1.0 / (far - near), 1.0 if endless else far / (far - near), 1.0
            m[3, :2] = -shift
        else:
            m[2, 2], m[2, 3], m[3, 2] = near / (far - near), -1.0, near if endless else near * far / (far - near)
            m[2, :2] = shift
        return m

    def project(self, points_world: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Project points of the world (N, 3) to pixels (N, 2), and to depths (N,) along the axis [stage units].

        Pixels are (column, row) from the top left corner, NaN for points outside of the field of view: for a pinhole
        camera the points in or behind its plane (depth <= 0), some of which a fisheye may see.

        Raises:
            Unsupported: the projection is not known, or its calibration gives no image.
        """
        points = np.asarray(points_world, np.float64).reshape(-1, 3)
        in_camera = points @ self.world_to_camera[:3, :3] + self.world_to_camera[3, :3]
        depth = -in_camera[:, 2]
        if self.lens is not None:
            return self.lens.to_pixels(in_camera), depth
        divisor = np.ones_like(depth)
        if self.projection_type == "pinhole":
            divisor = np.where(depth > 0, depth, np.nan)
        columns = self.cx + self.fx * in_camera[:, 0] / divisor
        rows = self.cy - self.fy * in_camera[:, 1] / divisor
        return np.stack([columns, rows], -1), depth

    def rays(self, pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the ray origins and unit directions (N, 3), in the camera's frame, of pixels (N, 2).

        Pixels are (column, row) from the top left corner. Directions are NaN where no light enters the lens.

        Raises:
            Unsupported: the projection is not known, or its calibration gives no image.
        """
        pixels = np.asarray(pixels, np.float64).reshape(-1, 2)
        if self.lens is not None:
            return self.lens.to_origins(pixels), self.lens.to_directions(pixels)
        origins = np.zeros((len(pixels), 3))
        plane = (pixels - (self.cx, self.cy)) / (self.fx, -self.fy)
        if self.projection_type == "orthographic":
            origins[:, :2] = plane
            return origins, np.broadcast_to((0.0, 0.0, -1.0), origins.shape)
        directions = np.concatenate([plane, -np.ones((len(pixels), 1))], axis=1)
        return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)

    def _require_linear(self, what: str) -> None:
        if self.projection_type not in LINEAR_PROJECTIONS:
            raise errors.Unsupported(
                f"{what} cannot be given for {self.prim_path}: its projection is {self.projection_type!r}, "
                f"and only {' and '.join(LINEAR_PROJECTIONS)} are linear"
            )


def read_camera(
    stage: Usd.Stage, path: str | Sdf.Path, resolution: tuple[int, int], *, time: Usd.TimeCode | None = None
) -> CameraView:
    """Read the camera at `path`, or the only camera below it, for images of (width, height) at `time` (or the default).

    Raises:
        BadPrim: there is no camera at or below `path`, or more than one below it.
        RenderError: the resolution, aperture, focal length or clipping range give no image.
    """
    prim = _camera_at(stage, path)
    width, height = (int(size) for size in resolution)
    time = Usd.TimeCode.Default() if time is None else time
    values = {attribute.GetName(): attribute.Get(time) for attribute in prim.GetAttributes()}
    numbers = {name: _number(prim, name, values[name]) for name in _FIELDS}
    near, far = _range(prim, values["clippingRange"])
    warn_of_clipping_planes(prim.GetPath(), values)
    if (projection := values.get("projection")) not in (None, "", "perspective", "orthographic"):
        errors.warn_once(
            f"{prim.GetPath()}: projection {projection!r} is neither perspective nor orthographic; perspective is "
            "used. Correct it; lenses have attributes of their own, such as cameraProjectionType."
        )
    projection_type, lens_parameters = read_lens(values)
    if unknown := undocumented_attributes(values):
        errors.warn_once(
            f"{prim.GetPath()}: {', '.join(unknown)} are ignored; author interpupillaryDistance [cm] and isLeftEye"
        )
    view = CameraView(
        prim_path=str(prim.GetPath()),
        width=width,
        height=height,
        local_to_world=_rigid(prim, _placed(prim, time)),
        clipping_range=(near, far),
        projection_type=projection_type,
        lens_parameters=lens_parameters,
        meters_per_unit=meters_per_unit(stage),
        attributes={name: value for name, value in values.items() if _is_other(name)},
        **{ours: numbers[name] for name, ours in _FIELDS.items()},  # pyright: ignore[reportArgumentType]
    )
    _check(view)
    return view


def _placed(prim: Usd.Prim, time: Usd.TimeCode) -> np.ndarray:
    try:
        return as_array(local_to_world(prim, time))
    except Tf.ErrorException as failure:
        raise errors.RenderError(
            f"the camera {prim.GetPath()} gives no image: its xformOps, or those above it, cannot be read: "
            f"{reason(failure).rstrip('.')}. Correct xformOpOrder and its ops"
        ) from failure


def _number(prim: Usd.Prim, name: str, value: Any) -> float:
    if not isinstance(value, (int, float)):
        raise errors.RenderError(f"the camera {prim.GetPath()} gives no image: {name} {value!r} is not a number")
    return float(value)


def _range(prim: Usd.Prim, value: Any) -> tuple[float, float]:
    if not isinstance(value, (Gf.Vec2f, Gf.Vec2d, Gf.Vec2h)):
        raise errors.RenderError(f"the camera {prim.GetPath()} gives no image: clippingRange {value!r} is not a pair")
    return float(value[0]), float(value[1])


def _camera_at(stage: Usd.Stage, path: str | Sdf.Path) -> Usd.Prim:
    prim = prim_at(stage, path)
    if prim.IsA(UsdGeom.Camera):
        return prim
    below = [each for each in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()) if each.IsA(UsdGeom.Camera)]
    if len(below) == 1:
        return below[0]
    found = below or [each for each in stage.Traverse() if each.IsA(UsdGeom.Camera)]
    names = ", ".join(str(each.GetPath()) for each in found[:8]) or "none"
    where = "below it" if below else "on the stage"
    raise errors.BadPrim(
        f"{prim.GetPath()} is a {prim.GetTypeName() or 'typeless prim'}, not a camera; cameras {where}: {names}"
    )


def _is_other(name: str) -> bool:
    return name not in _FIELDS and name != "clippingRange" and not name.startswith("xformOp")


def _rigid(prim: Usd.Prim, matrix: np.ndarray) -> np.ndarray:
    """Return a camera's transform with axes that are unit vectors, and perpendicular, as `Gf.Camera` makes them.

    Rays do not depend on a camera's scale, and depths must stay in stage units.
    """
    lengths = np.linalg.norm(matrix[:3, :3], axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        axes = matrix[:3, :3] / np.where(lengths > 0, lengths, 1.0)
    if np.isfinite(axes).all() and np.abs(axes @ axes.T - np.eye(3)).max() > _MOST_SHEAR and np.linalg.det(axes):
        errors.warn_once(
            f"{prim.GetPath()}: the camera is sheared by a scale above it; its axes are made perpendicular. Scale "
            "uniformly, or along the axes of the camera."
        )
        # Gf stops at 1e-6; the nearest orthonormal matrix takes the rest.
        u, _, vt = np.linalg.svd(np.array(Gf.Matrix3d(axes.tolist()).GetOrthonormalized(issueWarning=False)))
        axes = u @ vt
    if np.linalg.det(axes) < 0:
        errors.warn_once(
            f"{prim.GetPath()}: the camera is mirrored by a negative scale, so its pictures are, too, and no rotation "
            "describes poses in its frame. Scale it, and what is above it, by positive numbers."
        )
    return np.block([[axes, matrix[:3, 3:]], [matrix[3:]]])


def _not_finite(view: CameraView) -> str | None:
    """Return the first value in use that is NaN or infinite, as text; the far clipping plane may be infinite."""
    if not np.isfinite(view.local_to_world).all():
        return "a transform that is NaN or infinite"
    values = {usd: getattr(view, ours) for usd, ours in _FIELDS.items() if usd != "verticalAperture"}
    if view.f_stop == 0.0:
        del values["focusDistance"]
    return next((f"{name} {value}" for name, value in values.items() if not np.isfinite(value)), None)


def _check(view: CameraView) -> None:
    problem = None
    if view.width < 1 or view.height < 1:
        problem = f"a resolution of {view.width} x {view.height}"
    elif not view.horizontal_aperture > 0:
        problem = f"horizontalAperture {view.horizontal_aperture} (it must be above 0)"
    elif not view.focal_length > 0 and view.projection_type == "pinhole":
        problem = f"focalLength {view.focal_length} (it must be above 0)"
    elif not 0 < view.clipping_range[0] < view.clipping_range[1] and view.projection_type == "pinhole":
        problem = f"clippingRange {view.clipping_range} (near must be positive and below far)"
    elif view.clipping_range[0] < 0 and view.projection_type in LENS_MODELS:
        problem = f"clippingRange {view.clipping_range} (near must not be negative)"
    elif not -np.inf < view.clipping_range[0] < view.clipping_range[1]:
        problem = f"clippingRange {view.clipping_range} (near must be finite and below far)"
    elif (broken := _not_finite(view)) is not None:
        problem = broken
    elif np.abs(view.local_to_world[3, :3]).max() > np.finfo(np.float32).max:
        problem = "its place is farther from the origin than numbers of 32 bits reach"
    elif abs(np.linalg.det(view.local_to_world[:3, :3])) < 1e-9:
        problem = "a scale of zero in its transform"
    if problem:
        raise errors.RenderError(f"the camera {view.prim_path} gives no image: {problem}")
