"""Pixel correspondence between two cameras, such as a stereo pair."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from pxr import Sdf

from usdsdg.annotators.base import Annotation, define
from usdsdg.annotators.frame import Frame
from usdsdg.errors import AnnotatorError, warn_once
from usdsdg.session.render_products import HydraTexture, products
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.cameras.camera_view import CameraView, read_camera
from usdsdg.stage.cameras.pixels import pixel_centers

_REFERENCE = "crossCameraReferenceName"


@define("cross_correspondence", "CrossCorrespondence", aovs=["instance", "position"], dtype=np.float32)
def cross_correspondence(frame: Frame, params: Mapping[str, Any]) -> Annotation:
    """Displacement of each pixel from this image to that of the reference camera, float32 (H, W, 4): dx, dy, z, w.

    dx, dy: position in the reference image minus position here, each as a fraction of the width or height of its own
    image. z: 1 where the point is outside the reference image, else 0. w: 0, since occlusion in the reference view is
    not known. All four are -1 where nothing is hit.

    The reference camera is the one whose path, or name, or whose parent's name, is given by the camera's attribute
    `crossCameraReferenceName`; it must have a render product of its own. Of several of one name the one that is nearest
    in the tree of prims counts, as of pairs whose cameras are called alike.

    Raises:
        AnnotatorError: the attribute is not set, or no render product has such a camera.
        Unsupported: the lens of the reference camera has no closed-form projection.
    """
    reference = _reference_of(frame)
    seen = frame.aov("instance") >= 0
    rows, columns = np.nonzero(seen)
    pixels, depths = reference.project(frame.aov("position")[seen])
    size = np.array([reference.width, reference.height])
    with np.errstate(invalid="ignore"):
        inside = ((pixels >= 0) & (pixels < size)).all(axis=1)
    if reference.lens is None:
        # The near plane of an orthographic camera may be behind it.
        inside &= depths > min(reference.clipping_range[0], 0.0)
    shift = pixels / size - pixel_centers(columns, rows) / seen.shape[::-1]
    out = np.full((*seen.shape, 4), -1, np.float32)
    out[seen, :2] = np.nan_to_num(shift, nan=-1.0)
    out[seen, 2] = ~inside
    out[seen, 3] = 0
    return Annotation(out)


@define(
    "dense_correspondence", aovs=["instance", "triangle", "barycentrics"], params={"camera": None, "captures": 0},
    dtype=np.float32, info={"visibility": np.zeros((0, 0), np.uint8), "camera": "", "resolution": (0, 0)},
)  # fmt: skip
def dense_correspondence(frame: Frame, params: Mapping[str, Any]) -> Annotation:
    """Where the point that each pixel shows is in another picture, float32 (H, W, 2): column and row [pixels].

    Positions count from the top left corner; NaN where a pixel shows nothing, or its point has no position there.
    info: "visibility" uint8 (H, W): 0 not in the other picture, 1 occluded there, 2 visible there; "camera" and
    "resolution" (width, height) of the other picture.

    camera: path of the other camera, or of its render product, which tells the resolution; None is this one.
    captures: 0 follows the points of this picture; with n, pixels are those of the picture n captures ago, and the
        other picture is the present one. Points move with their surface: rigid, articulated, simulated or skinned;
        those of prims that are gone or have another topology now are nowhere.

    Raises:
        AnnotatorError: captures is negative.
        BadPrim: there is no such camera or render product.
    """
    captures = params["captures"]
    if isinstance(captures, bool) or not isinstance(captures, int) or captures < 0:
        raise AnnotatorError(f"dense_correspondence: captures is {captures!r}; expected 0 or more captures back")
    view = _other_camera(frame, params["camera"])
    pixels, states = frame.queries.follow(view, captures)
    info = {"visibility": states, "camera": view.prim_path, "resolution": (view.width, view.height)}
    return Annotation(pixels, info)


def _other_camera(frame: Frame, asked: Any) -> CameraView:
    if asked is None:
        return frame.camera
    path = str(getattr(asked, "path", asked))
    for product in _single_products():
        if path in (product.path, product.camera_path):
            return _view_of(product, frame)
    return read_camera(current_stage(), path, (frame.camera.width, frame.camera.height), time=frame.queries.time)


def _reference_of(frame: Frame) -> CameraView:
    camera = frame.camera
    name = camera.attributes.get(_REFERENCE)
    others = [product for product in _single_products() if product.camera_path != camera.prim_path]
    if not name:
        raise AnnotatorError(
            f"{camera.prim_path} has no {_REFERENCE}, which says which camera its pixels are looked up in; set it to "
            "the name of a camera that has a render product."
        )
    named = [product for product in others if _is_called(product.camera_path, name)]
    if not named:
        known = ", ".join(product.camera_path for product in others) or "none"
        raise AnnotatorError(
            f"{camera.prim_path}: {_REFERENCE} is {name!r}, and no render product has a camera of that name; others "
            f"have: {known}."
        )
    # Each pair of a rig may have cameras of the same two names: the other one of this pair is the nearest.
    shared = [_shared_elements(product.camera_path, camera.prim_path) for product in named]
    nearest = [product for product, count in zip(named, shared, strict=True) if count == max(shared)]
    if len(paths := dict.fromkeys(product.camera_path for product in nearest)) > 1:
        warn_once(
            f"{camera.prim_path}: {_REFERENCE} is {name!r}, as {' and '.join(paths)} are called; pixels are looked up "
            "in the first. Set it to the path of the camera that is meant."
        )
    same_size = (product for product in nearest if product.resolution == (camera.width, camera.height))
    return _view_of(next(same_size, nearest[0]), frame)


def _single_products() -> list[HydraTexture]:
    """Return the render products of one camera; one of tiles has no place for the pixels of its cameras."""
    return [product for product in products() if product.tiles is None]


def _view_of(product: HydraTexture, frame: Frame) -> CameraView:
    return read_camera(current_stage(), product.camera_path, product.resolution, time=frame.queries.time)


def _is_called(path: str, name: str) -> bool:
    """Return whether the camera at a path, or its parent, has a name, or it is the path."""
    return name == path or name in path.split("/")[-2:]


def _shared_elements(path: str, other: str) -> int:
    """Return how many elements two prim paths have in common from the root on."""
    return len(Sdf.Path(path).GetCommonPrefix(Sdf.Path(other)).GetPrefixes())
