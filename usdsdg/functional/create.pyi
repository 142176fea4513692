"""Signatures of the functions in create.py, which are generated at import."""

from typing import Any

from pxr import Usd

def scope(name: str | None = None, parent: Any = None) -> Usd.Prim:
    """A Scope, which groups prims and has no transform."""

def xform(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, name: str | None = None,
    parent: Any = None, material: Any = None,
) -> Usd.Prim:  # fmt: skip
    """An empty transform."""

def clone(
    path: Any, position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None,
    look_at_up_axis: Any = None, pivot: Any = None, relative_to: Any = None, name: str | None = None,
    parent: Any = None, *, semantics: Any = None, visible: Any = True,
) -> Usd.Prim:  # fmt: skip
    """A copy of the prim at `path` with everything below it."""

def reference(
    usd_path: Any = None, prim_path: Any = None, position: Any = None, scale: Any = None, rotation: Any = None,
    look_at: Any = None, look_at_up_axis: Any = None, pivot: Any = None, relative_to: Any = None, semantics: Any = None,
    visible: Any = True, name: str | None = None, parent: Any = None,
) -> Usd.Prim:  # fmt: skip
    """A reference to a USD file or to a prim of this stage."""

def camera(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    relative_to: Any = None, focal_length: Any = 24.0, focus_distance: Any = 400.0, f_stop: Any = 0.0,
    horizontal_aperture: Any = 20.955, horizontal_aperture_offset: Any = 0.0, vertical_aperture_offset: Any = 0.0,
    clipping_range: Any = (1.0, 1000000.0), projection_type: Any = "pinhole", fisheye_nominal_width: Any = 1936.0,
    fisheye_nominal_height: Any = 1216.0, fisheye_optical_centre_x: Any = 970.94244,
    fisheye_optical_centre_y: Any = 600.37482, openCV_focal_x: Any = 731.78788, openCV_focal_y: Any = 731.78789,
    fisheye_max_fov: Any = 200.0, fisheye_polynomial_a: Any = 0.0, fisheye_polynomial_b: Any = 0.00245,
    fisheye_polynomial_c: Any = 0.0, fisheye_polynomial_d: Any = 0.0, fisheye_polynomial_e: Any = 0.0,
    fisheye_polynomial_f: Any = 0.0, fisheye_p0: Any = -0.00037, fisheye_p1: Any = -0.00074, fisheye_s0: Any = -0.00058,
    fisheye_s1: Any = -0.00022, fisheye_s2: Any = 0.00019, fisheye_s3: Any = -0.0002,
    cross_camera_reference_name: Any = None, name: str | None = None, parent: Any = None, *, tick_rate: Any = None,
) -> Usd.Prim:  # fmt: skip
    """A camera that looks along its own -Z with +Y up, whatever the stage's up axis."""

def plane(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, name: str | None = None,
    parent: Any = None, material: Any = None, *, as_mesh: bool = True,
) -> Usd.Prim:  # fmt: skip
    """A square with edges of one meter that faces the stage's up axis."""

def sphere(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, as_mesh: bool = True,
    name: str | None = None, parent: Any = None, material: Any = None,
) -> Usd.Prim:  # fmt: skip
    """A sphere of one meter diameter."""

def torus(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, name: str | None = None,
    parent: Any = None, material: Any = None, *, as_mesh: bool = True,
) -> Usd.Prim:  # fmt: skip
    """A ring around the stage's up axis, one and a half meters across; always a mesh."""

def disk(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, name: str | None = None,
    parent: Any = None, material: Any = None, *, as_mesh: bool = True,
) -> Usd.Prim:  # fmt: skip
    """A flat disk of one meter diameter that faces the stage's up axis; always a mesh."""

def cube(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, as_mesh: bool = True,
    name: str | None = None, parent: Any = None, material: Any = None,
) -> Usd.Prim:  # fmt: skip
    """A cube with edges of one meter."""

def cylinder(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, as_mesh: bool = True, visible: Any = True,
    name: str | None = None, parent: Any = None, material: Any = None,
) -> Usd.Prim:  # fmt: skip
    """A cylinder of one meter height and diameter along the stage's up axis."""

def cone(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, as_mesh: bool = True,
    name: str | None = None, parent: Any = None, material: Any = None,
) -> Usd.Prim:  # fmt: skip
    """A cone of one meter height and base diameter along the stage's up axis."""

def capsule(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, as_mesh: bool = True,
    name: str | None = None, parent: Any = None, material: Any = None,
) -> Usd.Prim:  # fmt: skip
    """A capsule of one meter height and half a meter diameter along the stage's up axis. Since 6.0."""

def sphere_light(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True,
    color: Any = (1.0, 1.0, 1.0), intensity: Any = 30000.0, exposure: Any = None, color_temperature: Any = 6500,
    enable_color_temperature: Any = False, diffuse: Any = 1.0, specular: Any = 1.0, shaping_cone_angle: Any = 180.0,
    shaping_cone_softness: Any = 0.0, shaping_focus_tint: Any = (1.0, 1.0, 1.0), radius: Any = 1.0,
    name: str | None = None, parent: Any = None,
) -> Usd.Prim:  # fmt: skip
    """A light that emits from the surface of a sphere."""

def disk_light(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True,
    color: Any = (1.0, 1.0, 1.0), intensity: Any = 30000.0, exposure: Any = None, color_temperature: Any = 6500,
    enable_color_temperature: Any = False, diffuse: Any = 1.0, specular: Any = 1.0, shaping_cone_angle: Any = 180.0,
    shaping_cone_softness: Any = 0.0, shaping_focus_tint: Any = (1.0, 1.0, 1.0), radius: Any = 1.0,
    name: str | None = None, parent: Any = None,
) -> Usd.Prim:  # fmt: skip
    """A light that emits from a disk, toward -Z."""

def rect_light(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True,
    color: Any = (1.0, 1.0, 1.0), intensity: Any = 30000.0, exposure: Any = None, color_temperature: Any = 6500,
    enable_color_temperature: Any = False, diffuse: Any = 1.0, specular: Any = 1.0, shaping_cone_angle: Any = 180.0,
    shaping_cone_softness: Any = 0.0, shaping_focus_tint: Any = (1.0, 1.0, 1.0), height: Any = 1.0, width: Any = 1.0,
    name: str | None = None, parent: Any = None,
) -> Usd.Prim:  # fmt: skip
    """A light that emits from a rectangle, toward -Z."""

def cylinder_light(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True,
    color: Any = (1.0, 1.0, 1.0), intensity: Any = 30000.0, exposure: Any = None, color_temperature: Any = 6500,
    enable_color_temperature: Any = False, diffuse: Any = 1.0, specular: Any = 1.0, shaping_cone_angle: Any = 180.0,
    shaping_cone_softness: Any = 0.0, shaping_focus_tint: Any = (1.0, 1.0, 1.0), radius: Any = 1.0, length: Any = 1.0,
    name: str | None = None, parent: Any = None,
) -> Usd.Prim:  # fmt: skip
    """A light that emits from a cylinder along x."""

def distant_light(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True,
    color: Any = (1.0, 1.0, 1.0), intensity: Any = 30000.0, exposure: Any = None, color_temperature: Any = 6500,
    enable_color_temperature: Any = False, diffuse: Any = 1.0, specular: Any = 1.0, shaping_cone_angle: Any = 180.0,
    shaping_cone_softness: Any = 0.0, shaping_focus_tint: Any = (1.0, 1.0, 1.0), angle: Any = 1.0,
    name: str | None = None, parent: Any = None,
) -> Usd.Prim:  # fmt: skip
    """A light with parallel rays toward -Z."""

def dome_light(
    color: Any = (1.0, 1.0, 1.0), texture: Any = None, texture_format: Any = "latlong", intensity: Any = 1000.0,
    exposure: Any = 1.0, diffuse: Any = 1.0, specular: Any = 1.0, color_temperature: Any = 6500,
    enable_color_temperature: Any = False, position: Any = None, scale: Any = None, rotation: Any = None,
    look_at: Any = None, look_at_up_axis: Any = None, name: str | None = None, parent: Any = None,
) -> Usd.Prim:  # fmt: skip
    """An environment light, optionally with the image `texture`."""

def material(mdl: str, bind_prims: Any = None, name: str | None = None, parent: Any = None, **inputs: Any) -> Usd.Prim:
    """An MDL material such as "OmniPBR.mdl" with the given `inputs`, bound to any number of prims."""

def omni_lidar(
    position: Any = None, rotation: Any = None, name: str | None = None, parent: Any = None, **attributes: Any
) -> Usd.Prim:
    """Unsupported: usdsdg has no lidar model."""

def omni_radar(
    position: Any = None, rotation: Any = None, name: str | None = None, parent: Any = None, **attributes: Any
) -> Usd.Prim:
    """Unsupported: usdsdg has no radar model."""
