"""Cameras with all of Omniverse's lens models."""

from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.arguments.tick_rates import author_tick_rate
from usdsdg.arguments.values import shown
from usdsdg.errors import ArgumentError
from usdsdg.functional.arguments import per_prim
from usdsdg.functional.new_prims import apply_common_arguments, define, new_paths, numbers
from usdsdg.stage.cameras.lens_attributes import LENS, OLD_PROJECTIONS, OPTICS, PROJECTIONS


def camera(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    relative_to: Any = None, focal_length: Any = 24.0, focus_distance: Any = 400.0, f_stop: Any = 0.0,
    horizontal_aperture: Any = 20.955, horizontal_aperture_offset: Any = 0.0, vertical_aperture_offset: Any = 0.0,
    clipping_range: Any = (1.0, 1000000.0), projection_type: Any = "pinhole", fisheye_nominal_width: Any = 1936.0,
    fisheye_nominal_height: Any = 1216.0, fisheye_optical_centre_x: Any = 970.94244,
    fisheye_optical_centre_y: Any = 600.37482, openCV_focal_x: Any = 731.78788, openCV_focal_y: Any = 731.78789,
    fisheye_max_fov: Any = 200.0, fisheye_polynomial_a: Any = 0.0, fisheye_polynomial_b: Any = 0.00245,
    fisheye_polynomial_c: Any = 0.0, fisheye_polynomial_d: Any = 0.0, fisheye_polynomial_e: Any = 0.0,
    fisheye_polynomial_f: Any = 0.0, fisheye_p0: Any = -0.00037, fisheye_p1: Any = -0.00074,
    fisheye_s0: Any = -0.00058, fisheye_s1: Any = -0.00022, fisheye_s2: Any = 0.00019, fisheye_s3: Any = -0.0002,
    cross_camera_reference_name: Any = None, count: int = 1, name: str | None = None, parent: Any = None, *,
    tick_rate: Any = None,
) -> list[Usd.Prim]:  # fmt: skip
    """Cameras that look along their own -Z with +Y up, whatever the stage's up axis.

    Focal length and apertures are in tenths of a stage unit, `focus_distance` and `clipping_range` (near, far) in stage
    units; `f_stop` 0 disables depth of field. The fisheye and OpenCV parameters are in pixels of the nominal size,
    `fisheye_max_fov` in degrees. Names of projections may be written in snake_case. `tick_rate`, frames per second, is
    authored only: every capture renders every camera.

    Raises:
        ArgumentError: an unknown projection, or a clipping range that is not two numbers.
        ArgumentError: `tick_rate` is not a number, 0 or more.
    """
    arguments = dict(locals())
    rate = arguments.pop("tick_rate")
    projections = [_projection(each) for each in per_prim(arguments.pop("projection_type"), count)]
    ranges = _ranges(arguments.pop("clipping_range"), count)
    prims = define(
        new_paths(arguments.pop("name") or "Camera", arguments.pop("parent"), arguments.pop("count")), "Camera"
    )
    author_tick_rate(prims, rate)
    for prim, projection, (near, far) in zip(prims, projections, ranges):
        UsdGeom.Camera(prim).CreateClippingRangeAttr(Gf.Vec2f(near, far))
        prim.CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token, custom=False).Set(projection)
    for argument, attribute in (OPTICS | LENS).items():
        for prim, value in zip(prims, numbers(argument, arguments.pop(argument), len(prims)) or ()):
            prim.CreateAttribute(attribute, Sdf.ValueTypeNames.Float, custom=False).Set(value)
    for prim, value in zip(prims, per_prim(arguments.pop("cross_camera_reference_name"), len(prims))):
        if value is not None:
            reference = prim.CreateAttribute("crossCameraReferenceName", Sdf.ValueTypeNames.String, custom=False)
            reference.Set(str(value))
    return apply_common_arguments(prims, **arguments)


def _projection(name: Any) -> str:
    first, *others = str(name).split("_")
    known = first + "".join(part.capitalize() for part in others)
    if known not in (*PROJECTIONS, *OLD_PROJECTIONS):
        raise ArgumentError(f"projection_type is {name!r}; expected one of {', '.join(PROJECTIONS)}")
    return known


def _ranges(value: Any, count: int) -> list[list[float]]:
    """Return (near, far) of each camera."""
    pairs = np.asarray(value, np.float64) if isinstance(value, (list, tuple, np.ndarray)) else np.zeros(0)
    if pairs.shape not in ((2,), (1, 2), (count, 2)):
        raise ArgumentError(f"clipping_range is {shown(value)}; expected (near, far), or a list with one per camera")
    return np.broadcast_to(pairs, (count, 2)).tolist()
