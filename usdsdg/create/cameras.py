"""Cameras with all of Omniverse's lens models: `rep.create.camera`, `stereo_camera` and `camera_rig`."""

import inspect
import os
from typing import Any

from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg import modify
from usdsdg.arguments.prim_names import prim_name
from usdsdg.arguments.tick_rates import author_tick_rate
from usdsdg.arguments.values import count_of, vector
from usdsdg.calibration.calibration import author_calibration
from usdsdg.calibration.files import read_calibration, read_rig
from usdsdg.calibration.rig import author_mount
from usdsdg.create.objects import apply_common_arguments, new_object, new_xform
from usdsdg.errors import ArgumentError
from usdsdg.graph.node import ReplicatorItem
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.cameras.lens_attributes import LENS, OLD_PROJECTIONS, OPTICS, PROJECTIONS
from usdsdg.stage.cameras.stereo_pairs import STEREO_SIDES
from usdsdg.stage.poses import transforms


def camera(
    position: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    focal_length: Any = 24.0, focus_distance: Any = 400.0, f_stop: Any = 0.0, horizontal_aperture: Any = 20.955,
    horizontal_aperture_offset: Any = 0.0, vertical_aperture_offset: Any = 0.0,
    clipping_range: tuple[float, float] = (1.0, 1000000.0), projection_type: str = "pinhole",
    fisheye_nominal_width: Any = 1936.0, fisheye_nominal_height: Any = 1216.0,
    fisheye_optical_centre_x: Any = 970.94244, fisheye_optical_centre_y: Any = 600.37482,
    openCV_focal_x: Any = 731.78788, openCV_focal_y: Any = 731.78789, fisheye_max_fov: Any = 200.0,
    fisheye_polynomial_a: Any = 0.0, fisheye_polynomial_b: Any = 0.00245, fisheye_polynomial_c: Any = 0.0,
    fisheye_polynomial_d: Any = 0.0, fisheye_polynomial_e: Any = 0.0, fisheye_polynomial_f: Any = 0.0,
    fisheye_p0: Any = -0.00037, fisheye_p1: Any = -0.00074, fisheye_s0: Any = -0.00058, fisheye_s1: Any = -0.00022,
    fisheye_s2: Any = 0.00019, fisheye_s3: Any = -0.0002, cross_camera_reference_name: Any = None,
    count: int = 1, parent: Any = None, name: str | None = None, *, tick_rate: Any = None,
    calibration: str | os.PathLike[str] | None = None,
) -> ReplicatorItem:  # fmt: skip
    """Create cameras. Focal length and apertures are in tenths of a stage unit, distances in stage units.

    In a Z-up stage the camera looks along its object's -X with +Z up, as in Replicator: the child prim has a fixed
    rotation for this.

    Args:
        f_stop: 0 disables depth of field.
        projection_type: camelCase or snake_case; docs/lenses.md has the formulas, and the attributes of
            omniDirectionalStereo and generalizedProjection, which have no argument here.
        fisheye_nominal_width: pixels, as are nominal height, optical center and OpenCV focal lengths.
        fisheye_max_fov: degrees.
        cross_camera_reference_name: the other camera of a stereo pair, for cross correspondence.
        tick_rate: frames per second of the sensor, which is authored only: every capture renders every camera.
        calibration: YAML file of OpenCV, ROS or Kalibr with the lens of a real camera, instead of all arguments of the
            lens; `camchain.yaml#cam1` is one of several. Give the render product the size of its pictures.

    Raises:
        ArgumentError: an unknown projection, or a clipping range that is not two numbers.
        ArgumentError: `tick_rate` is not a number, 0 or more, or `calibration` is given with arguments of the lens.
        ConfigError: the calibration cannot be read, or no lens here can express it.
    """
    arguments = dict(locals())
    lens = None if calibration is None else read_calibration(calibration)
    if lens is not None:
        _refuse_lens_arguments(arguments)
    stage = current_stage()
    objects, cameras = [], []
    for _ in range(count_of(count)):
        path, child = new_object("Camera", name, parent)
        objects.append(path)
        cameras.append(_camera_at(stage, child))
    author_tick_rate(cameras, tick_rate)
    item = _with_arguments("OgnCreateCamera", objects, cameras, arguments)
    if lens is not None:
        for prim in cameras:
            author_calibration(prim, lens)
    return item


def camera_rig(
    rig: str | os.PathLike[str],
    position: Any = None,
    rotation: Any = None,
    look_at: Any = None,
    look_at_up_axis: Any = None,
    *,
    clipping_range: tuple[float, float] = (1.0, 1000000.0),
    parent: Any = None,
    name: str | None = None,
) -> ReplicatorItem:
    """Create calibrated cameras that move as one: an Xform with a camera prim below it for each of the rig.

    The rig's z axis is ahead as a camera of `camera` looks; of Kalibr's files the rig is the first camera. `look_at`
    turns the rig so that its first camera looks in that direction. `get_output_prims()["prims"][0].GetChildren()` are
    its cameras, in the order of the file.

    Args:
        rig: YAML file: Kalibr's camchain, or a list called `rig` of mappings with `name`, `calibration` (a file, or the
            keys of one) and the camera's place in the rig: `translation` [meters] and `quaternion` (w, x, y, z), or a
            4 x 4 `matrix`, from the camera to the rig, both with x right, y down and z ahead.

    Raises:
        ConfigError: the file cannot be read, or a camera or its place is not usable; the message says what is.
        ArgumentError: a clipping range that is not two numbers.
    """
    mounts = read_rig(rig).mounts
    near, far = vector("clipping_range", clipping_range, 2)
    stage, prim = current_stage(), new_xform(name or "CameraRig", parent)
    for mount in mounts:
        made = author_mount(stage, str(prim.GetPath()), mount)
        UsdGeom.Camera(made).CreateClippingRangeAttr(Gf.Vec2f(near, far))
    pose = {"position": position, "rotation": rotation, "look_at": look_at, "look_at_up_axis": look_at_up_axis}
    return apply_common_arguments([str(prim.GetPath())], kind="OgnCreateCameraRig", name=name, **pose)


def _refuse_lens_arguments(arguments: dict[str, Any]) -> None:
    """Raise an ArgumentError where arguments of `camera` say another lens than the calibration."""
    defaults = inspect.signature(camera).parameters
    names = ("focal_length", "horizontal_aperture", "horizontal_aperture_offset", "vertical_aperture_offset")
    given = [name for name in (*names, "projection_type", *LENS) if arguments[name] != defaults[name].default]
    if given:
        raise ArgumentError(f"camera: {', '.join(given)} cannot be given with a calibration, which is the whole lens")


def stereo_camera(
    stereo_baseline: Any, position: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    focal_length: Any = 24.0, focus_distance: Any = 400.0, f_stop: Any = 0.0, horizontal_aperture: Any = 20.955,
    horizontal_aperture_offset: Any = 0.0, vertical_aperture_offset: Any = 0.0,
    clipping_range: tuple[float, float] = (1.0, 1000000.0), projection_type: str = "pinhole",
    fisheye_nominal_width: Any = 1936.0, fisheye_nominal_height: Any = 1216.0,
    fisheye_optical_centre_x: Any = 970.94244, fisheye_optical_centre_y: Any = 600.37482,
    openCV_focal_x: Any = 731.78788, openCV_focal_y: Any = 731.78789, fisheye_max_fov: Any = 200.0,
    fisheye_polynomial_a: Any = 0.0, fisheye_polynomial_b: Any = 0.00245, fisheye_polynomial_c: Any = 0.0,
    fisheye_polynomial_d: Any = 0.0, fisheye_polynomial_e: Any = 0.0, fisheye_polynomial_f: Any = 0.0,
    fisheye_p0: Any = -0.00037, fisheye_p1: Any = -0.00074, fisheye_s0: Any = -0.00058, fisheye_s1: Any = -0.00022,
    fisheye_s2: Any = 0.00019, fisheye_s3: Any = -0.0002, cross_camera_reference_name: Any = None,
    count: int = 1, name: str | None = None, parent: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Create stereo pairs: Xforms `/Replicator/<name>` with cameras `<name>_L_Xform/<name>_L` and the same of `_R`.

    Position and rotation apply to the Xform, which is called StereoCam without a name. The cameras have parallel view
    directions and are `stereo_baseline` [stage units] apart along the image's x axis. All other arguments are those of
    `camera`, but that the cameras of a fisheyePolynomial pair refer to each other for cross correspondence by default.

    Raises:
        ArgumentError: `stereo_baseline` is not a number, or as for `camera`.
    """
    arguments = dict(locals())
    label = prim_name(name) if name else "StereoCam"
    try:
        half = float(stereo_baseline) / 2
    except (TypeError, ValueError):
        raise ArgumentError(f"stereo_baseline is {stereo_baseline!r}; expected a number") from None
    if arguments["cross_camera_reference_name"] is None and projection_of(projection_type) == "fisheyePolynomial":
        arguments["cross_camera_reference_name"] = [f"{label}{side}" for side in STEREO_SIDES[::-1]] * count_of(count)
    stage = current_stage()
    # The image's right is +X of the child camera: +Y of the object in a Z-up stage.
    right = Gf.Vec3d(0, 1, 0) if transforms.up_axis(stage) == "Z" else Gf.Vec3d(1, 0, 0)
    pairs, cameras = [], []
    for _ in range(count_of(count)):
        pairs.append(str(new_xform(label, parent).GetPath()))
        for side, shift in zip(STEREO_SIDES, (-half, half)):
            _, child = new_object("Camera", f"{label}{side}", pairs[-1], {"translate": right * shift})
            cameras.append(_camera_at(stage, child))
    return _with_arguments("OgnCreateStereoCamera", pairs, cameras, arguments)


def _camera_at(stage: Usd.Stage, path: str) -> Usd.Prim:
    made = UsdGeom.Camera.Define(stage, path)
    if transforms.up_axis(stage) == "Z":
        made.AddRotateXYZOp().Set(Gf.Vec3f(90, 0, 90))
    return made.GetPrim()


def _with_arguments(
    kind: str, objects: list[str], cameras: list[Usd.Prim], arguments: dict[str, Any]
) -> ReplicatorItem:
    """Write the poses of `objects` and the lens of their cameras, or schedule distributions; return the item."""
    pose = {name: arguments[name] for name in ("position", "rotation", "look_at", "look_at_up_axis")}
    item = apply_common_arguments(objects, kind=kind, name=arguments["name"], **pose)
    _write_lens(cameras, arguments)
    return item


def _write_lens(cameras: list[Usd.Prim], lens: dict[str, Any]) -> None:
    """Write the lens arguments of `camera`; fisheye and OpenCV attributes only if the projection is not a pinhole."""
    projection = projection_of(lens["projection_type"])
    near, far = vector("clipping_range", lens["clipping_range"], 2)
    for prim in cameras:
        UsdGeom.Camera(prim).CreateClippingRangeAttr(Gf.Vec2f(near, far))
    written = dict(OPTICS)
    if projection != "pinhole":
        written |= LENS
        for prim in cameras:
            prim.CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token, custom=False).Set(projection)
            for attribute in LENS.values():
                prim.CreateAttribute(attribute, Sdf.ValueTypeNames.Float, custom=False)
    if cameras:
        for argument, attribute in written.items():
            modify.apply_or_schedule(attribute, lens[argument], cameras)
    others = lens["cross_camera_reference_name"]
    for index, prim in enumerate(cameras if others is not None else ()):
        other = others[index] if isinstance(others, list) and len(others) == len(cameras) else others
        prim.CreateAttribute("crossCameraReferenceName", Sdf.ValueTypeNames.String, custom=False).Set(str(other))


def projection_of(name: Any) -> str:
    """Return the name of a lens model in camelCase.

    Raises:
        ArgumentError: there is no such lens model.
    """
    first, *others = str(name).split("_")
    known = first + "".join(part[:1].upper() + part[1:] for part in others)
    by_folded = {each.lower(): each for each in (*PROJECTIONS, *OLD_PROJECTIONS)}
    if known.lower() not in by_folded:
        raise ArgumentError(f"projection_type is {name!r}; expected one of {', '.join(PROJECTIONS)}")
    return by_folded[known.lower()]
