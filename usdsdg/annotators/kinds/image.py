"""Annotators that return one AOV: color, depth, normals, motion, material channels."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import Annotation, define
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.pixels import encodings
from usdsdg.annotators.pixels.encodings import HALF_MAX

Params = Mapping[str, Any]


@define("rgb", "LdrColor", needs_path_tracing=True, dtype=np.uint8)
def rgb(frame: Frame, params: Params) -> Annotation:
    """Tone-mapped color, uint8 (H, W, 4), alpha 255."""
    return Annotation(frame.image("LdrColor"))


@define("HdrColor", needs_path_tracing=True, dtype=np.float16)
def hdr_color(frame: Frame, params: Params) -> Annotation:
    """Linear color, float16 (H, W, 4)."""
    return Annotation(frame.image("HdrColor"))


@define("distance_to_camera", aovs=["distance_to_camera"], dtype=np.float32)
def distance_to_camera(frame: Frame, params: Params) -> Annotation:
    """Distance from the camera's center [m], float32 (H, W); +inf where nothing is hit."""
    return Annotation(frame.image("distance_to_camera"))


@define("distance_to_image_plane", "DepthLinearized", aovs=["distance_to_image_plane"], dtype=np.float32)
def distance_to_image_plane(frame: Frame, params: Params) -> Annotation:
    """Distance along the optical axis [m], float32 (H, W); +inf where nothing is hit."""
    return Annotation(frame.image("distance_to_image_plane"))


@define("PtZDepth", aovs=["distance_to_image_plane"], dtype=np.float16)
def z_depth(frame: Frame, params: Params) -> Annotation:
    """distance_to_image_plane [m] as float16 (H, W, 4), in the first three channels; the fourth is 1."""
    return Annotation(encodings.halves(frame.image("distance_to_image_plane")))


@define("PtWorldNormal", aovs=["normals"], dtype=np.float16)
def world_normals(frame: Frame, params: Params) -> Annotation:
    """As normals, float16 (H, W, 4)."""
    return Annotation(encodings.halves(frame.image("normals")))


@define("normals", "SmoothNormal", aovs=["normals"], dtype=np.float32)
def normals(frame: Frame, params: Params) -> Annotation:
    """Unit normals in the world, float32 (H, W, 4); 0 0 0 where nothing is hit. The fourth channel is 1."""
    return Annotation(encodings.floats(frame.image("normals"), 1.0))


@define("motion_vectors", "MotionVectors", "Motion2d", aovs=["motion_vectors"], dtype=np.float32)
def motion_vectors(frame: Frame, params: Params) -> Annotation:
    """Motion since the last frame [pixels], float32 (H, W, 4): +x moved left, +y moved up, the rest 0.

    Replicator documents only the format of Motion2d; here it is the same array.
    """
    return Annotation(encodings.floats(frame.image("motion_vectors"), 0.0))


@define("PtWorldPos", aovs=["position"], dtype=np.float16)
def world_position(frame: Frame, params: Params) -> Annotation:
    """The hit point in the world [stage units], float16 (H, W, 4); the fourth channel is 1.

    Half precision as in Replicator's path tracer; pointcloud has the points in float32.
    """
    return Annotation(encodings.halves(frame.image("position")))


@define("DiffuseAlbedo", aovs=["albedo"], dtype=np.uint8)
def diffuse_albedo(frame: Frame, params: Params) -> Annotation:
    """Base color, linear, uint8 (H, W, 4)."""
    return Annotation(encodings.eight_bits(frame.image("albedo")))


@define("SpecularAlbedo", "PtReflectionFilter", aovs=["specular"], dtype=np.float16)
def specular_albedo(frame: Frame, params: Params) -> Annotation:
    """Specular reflectance at normal incidence, linear, float16 (H, W, 4); the fourth channel is 1."""
    return Annotation(encodings.halves(frame.image("specular")))


@define("PtDiffuseFilter", aovs=["diffuse"], dtype=np.float16)
def diffuse_filter(frame: Frame, params: Params) -> Annotation:
    """Diffuse reflectance, linear, float16 (H, W, 4): 0 for metals; the fourth channel is 1."""
    return Annotation(encodings.halves(frame.image("diffuse")))


@define("Roughness", aovs=["roughness"], dtype=np.uint8)
def roughness(frame: Frame, params: Params) -> Annotation:
    """Roughness, uint8 (H, W, 4): 0 (mirror) to 255 in three equal channels; the fourth channel is 255."""
    return Annotation(encodings.eight_bits(frame.image("roughness")))


@define("BumpNormal", aovs=["bump_normals"], dtype=np.float32)
def bump_normals(frame: Frame, params: Params) -> Annotation:
    """As normals, with the material's normal map."""
    return Annotation(encodings.floats(frame.image("bump_normals"), 1.0))


@define("PtSelfIllumination", aovs=["emission"], dtype=np.float16)
def self_illumination(frame: Frame, params: Params) -> Annotation:
    """Emitted radiance of the surface at the pixel's center [nits], linear, float16 (H, W, 4).

    The fourth channel is 1.
    """
    return Annotation(encodings.halves(frame.image("emission"), limit=HALF_MAX))


@define("EmissionAndForegroundMask", aovs=["emission", "instance"], dtype=np.float16)
def emission_and_foreground_mask(frame: Frame, params: Params) -> Annotation:
    """Emitted radiance of the surface at the pixel's center [nits], linear, float16 (H, W, 4).

    The fourth channel is the mask: 1 where there is geometry, 0 where nothing is hit. Replicator documents a single
    channel, which is not enough for both.
    """
    return Annotation(encodings.halves(frame.image("emission"), limit=HALF_MAX, instance=frame.image("instance")))


@define("PtBackground", aovs=["instance"], needs_path_tracing=True, dtype=np.float16)
def background(frame: Frame, params: Params) -> Annotation:
    """HdrColor where the pixel's center hits no geometry, else 0; float16 (H, W, 4).

    At silhouettes pixels of HdrColor are anti-aliased, so they contain light of the geometry.
    """
    return Annotation(encodings.behind_everything(frame.image("HdrColor"), frame.image("instance")))


@define("LdrColorIsaacConvertRGBAToRGB", needs_path_tracing=True, dtype=np.uint8)
def rgb_without_alpha(frame: Frame, params: Params) -> Annotation:
    """Tone-mapped color, uint8 (H, W, 3)."""
    return Annotation(encodings.without_alpha(frame.image("LdrColor")))
