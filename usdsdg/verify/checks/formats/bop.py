"""BOP: masks, boxes and counts of the objects, and poses that project their models onto them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.formats.bop import Posed, Scene
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.truth import Thing, Truth
from usdsdg.verify.checks.compare import beyond, differs, is_rotation, of_pixels, text
from usdsdg.writers.formats.bop.bop_files import CAMERAS, INFOS, MILLIMETERS, MODELS_INFO, NAME, POSES
from usdsdg.writers.formats.bop.bop_records import box_of
from usdsdg.writers.formats.shapes.masks import extent
from usdsdg.writers.formats.shapes.opencv_frame import TO_OPENCV

_FILTERED = "bounding_box_3d_fast"
_REACH = 2.0  # pixels by which the box of a model's projected points may differ from the object's
_NEAR = 1.0  # of the camera [mm]
_RADIUS = 0.75  # pixels: every circle that is larger than half the diagonal of a pixel is hit
_SAMPLES = 16  # pixels at which depths are compared
_DEPTH, _STEP = 2e-3, 1.0  # by which depths may differ: of the depth, and [mm]
_EDGE, _MOST = 1e-3, 0.8  # barycentrics outside of a triangle that count, and the fraction of pixels that shall agree
_THIN = 1.5  # pixels: objects that are thinner need not be hit along their whole length


def check(seen: Seen) -> Faults:
    """Check the objects of an image."""
    if seen.format != NAME:
        return
    scene: Scene = seen.extra["scene"]
    covered: np.ndarray | None = None
    for index, posed in enumerate(scene.objects):
        yield from _object(seen, scene, index, posed)
        if posed.visible is not None:
            covered = posed.visible.astype(int) if covered is None else covered + posed.visible
    if covered is not None and (covered > 1).any():
        yield Fault(scene.file, seen.name, f"visible masks overlap in {of_pixels(covered > 1)}")
    if seen.truth is not None:
        yield from _recorded(seen, scene, seen.truth)


def _object(seen: Seen, scene: Scene, index: int, posed: Posed) -> Faults:
    """What the files say of one object agrees."""
    file, name, info = scene.file.replace(POSES, INFOS), f"object {index}", posed.info
    rotation = np.array(posed.pose["cam_R_m2c"], np.float64).reshape(3, 3)
    if not is_rotation(rotation, absolute=1e-5):
        yield Fault(scene.file, seen.name, f"cam_R_m2c of {name} is no rotation", "", text(rotation))
    if posed.whole is not None and posed.visible is not None:
        counts = {"px_count_visib": posed.visible.sum()}
        if seen.depths and seen.depths[0].values.shape == posed.whole.shape:
            counts["px_count_valid"] = (posed.whole & np.isfinite(seen.depths[0].values)).sum()
        for key, count in counts.items():
            if differs(info[key], int(count), relative=0.0):
                yield Fault(file, seen.name, f"{key} of {name}", str(int(count)), str(info[key]))
        if (posed.visible & ~posed.whole).any():
            yield Fault(scene.masks[2 * index], seen.name, f"the mask of {name} does not contain what is visible")
        box = box_of(extent(posed.visible))
        if list(info["bbox_visib"]) != box:
            yield Fault(file, seen.name, f"bbox_visib of {name}", str(box), str(info["bbox_visib"]))
        inside = extent(posed.whole) if posed.visible.any() else None
        if not _holds(info["bbox_obj"], inside, posed.whole.shape):
            found = str(info["bbox_obj"])
            yield Fault(file, seen.name, f"bbox_obj of {name} holds its mask's extent", str(box_of(inside)), found)
        if not int(posed.whole.sum()) <= info["px_count_all"] < np.inf:
            yield Fault(
                file,
                seen.name,
                f"px_count_all of {name} is at least that of its mask",
                str(int(posed.whole.sum())),
                str(info["px_count_all"]),
            )
    fraction = float(info["px_count_visib"]) / max(float(info["px_count_all"]), 1.0)
    if differs(info["visib_fract"], fraction, relative=0.0, absolute=1e-6):
        yield Fault(file, seen.name, f"visib_fract of {name}", f"{fraction:.6f}", f"{float(info['visib_fract']):.6f}")
    yield from _projected(seen, scene, name, posed)


def _holds(box: Sequence[int], inside: tuple[int, int, int, int] | None, shape: tuple[int, ...]) -> bool:
    """Return whether a box holds the extent of what is in the picture, and is that where it is in the picture whole."""
    if inside is None:
        return list(box) == box_of(None)
    left, top, right, bottom = box[0], box[1], box[0] + box[2], box[1] + box[3]
    if left >= 0 and top >= 0 and right < shape[1] and bottom < shape[0]:
        return (left, top, right, bottom) == inside
    return left <= inside[0] and top <= inside[1] and right >= inside[2] and bottom >= inside[3]


def _projected(seen: Seen, scene: Scene, name: str, posed: Posed) -> Faults:
    """The pose projects the points of its model into the box of the whole object."""
    number = int(posed.pose["obj_id"])
    mesh = scene.models.mesh(number)
    if mesh is None:
        yield Fault(scene.file, seen.name, f"{name} is of model {number}, which is not there")
        return
    info, expected = scene.models.info.get(str(number)) or {}, scene.models.measures(number)
    if any(differs(info.get(key, np.nan), value, relative=1e-4) for key, value in expected.items()):
        yield Fault(MODELS_INFO, "all", f"model {number} [mm]", str(expected), str(info))
    rotation = np.array(posed.pose["cam_R_m2c"], np.float64).reshape(3, 3)
    model, triangles = mesh
    points = model @ rotation.T + np.array(posed.pose["cam_t_m2c"], np.float64)
    x, y, width, height = (float(each) for each in posed.info["bbox_obj"])
    if (points[:, 2] < _NEAR).any() or posed.whole is None or width < 0:
        return
    pixels = points @ scene.camera.T
    pixels = pixels[:, :2] / pixels[:, 2:] + 0.5  # from the corner of the image, as edges of boxes are
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    # The box ends one picture beyond the picture; what is left of the object there may be smaller on any side.
    size = np.array(posed.whole.shape[::-1], np.float64)
    is_cut = bool((low < -size).any() or (high > 2 * size).any())
    low, high = np.maximum(low, -size), np.minimum(high, 2 * size)
    past = np.array([*(low - (x, y)), *((x + width + 1, y + height + 1) - high)])
    # Rays through the centers of pixels miss the ends of what is thinner than a pixel.
    is_thin = float(posed.info["px_count_all"]) < _THIN * (high - low).max()
    hit = _hit_ends(pixels[triangles])
    missed = 0.0
    if len(hit) and not is_thin and not is_cut and not _is_clipped(points, seen.truth):
        missed = max(((x, y) - hit.min(axis=0)).max(), (hit.max(axis=0) - (x + width + 1, y + height + 1)).max())
    is_missed = bool(beyond(missed, _REACH).any()) and not _is_cut_out(seen, scene, posed, points[triangles])
    if beyond(past, _REACH).any() or is_missed:
        found = text([x, y, width, height])
        yield Fault(scene.file, seen.name, f"{name} projects to its box", text([*low, *(high - low - 1)]), found)


def _is_cut_out(seen: Seen, scene: Scene, posed: Posed, triangles: np.ndarray) -> bool:
    """Return whether the model (T, 3, 3) [mm] has the depths of the object, which then ends before it: it has holes.

    Opacity makes holes in what is drawn, which models do not have. Where no depth is known none is judged.
    """
    found = _depths(seen, posed)
    if found is None or not len(found[0]):
        return True
    pixels, depths = found
    rays = np.concatenate([pixels, np.ones((len(pixels), 1))], axis=1) @ np.linalg.inv(scene.camera).T
    hits = _hits(rays, triangles)
    agree = (np.abs(hits - depths[:, None]) <= _DEPTH * depths[:, None] + _STEP).any(axis=1)
    return bool(agree.mean() >= _MOST)


def _depths(seen: Seen, posed: Posed) -> tuple[np.ndarray, np.ndarray] | None:
    """Return some pixels (N, 2) at which an object is visible, from the center of the first one, and depths [mm]."""
    if posed.visible is None:
        return None
    truth = seen.truth
    if truth is not None and truth.plane_depth is not None and posed.visible.shape == truth.product.shape:
        rows, columns = (each.ravel() for each in truth.grid)
        depths = truth.plane_depth.ravel()
    elif seen.depths and seen.depths[0].values.shape == posed.visible.shape:
        rows, columns = (each.ravel() for each in np.indices(posed.visible.shape))
        depths = seen.depths[0].values.ravel()
    else:
        return None
    known = np.flatnonzero(posed.visible[rows, columns] & np.isfinite(depths))
    chosen = known[:: -(-len(known) // _SAMPLES) or 1]
    return np.stack([columns, rows], axis=1)[chosen].astype(float), depths[chosen] * MILLIMETERS


def _hits(rays: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the depth at which each ray (N, 3) from the origin, with z = 1, meets each triangle (T, 3, 3), (N, T)."""
    corner, first, second = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    normals = np.cross(first, second)
    with np.errstate(divide="ignore", invalid="ignore"):
        depths = (corner * normals).sum(axis=1) / (rays @ normals.T)
        away = rays[:, None] * depths[..., None] - corner
        scale = (normals**2).sum(axis=1)
        u = (np.cross(away, second) * normals).sum(axis=2) / scale
        v = (np.cross(first, away) * normals).sum(axis=2) / scale
        inside = (u >= -_EDGE) & (v >= -_EDGE) & (u + v <= 1.0 + _EDGE)
    return np.where(inside, depths, np.inf)


def _is_clipped(points: np.ndarray, truth: Truth | None) -> bool:
    """Return whether a plane of the recorded camera cuts off some of the points (N, 3), in its frame [mm]."""
    if truth is None or truth.camera is None:
        return False
    near, far = np.array(truth.camera.clipping_range) * truth.camera.meters_per_unit * MILLIMETERS
    return bool((points[:, 2] < near).any() or (points[:, 2] > far).any())


def _hit_ends(corners: np.ndarray) -> np.ndarray:
    """Return points (N, 2) near the ends of triangles (T, 3, 2) [pixels], beside which rays hit.

    That is the corners of small triangles. Rays pass the ends of what is pointed, so those of others are the centers of
    the circles in each corner that are as wide as the diagonal of a pixel; where there are none rays may miss.
    """
    edges = np.roll(corners, -1, axis=1) - corners
    lengths = np.linalg.norm(edges, axis=2)
    is_small = lengths.max(axis=1) < _REACH
    opposite, around = np.roll(lengths, -1, axis=1), np.maximum(lengths.sum(axis=1), 1e-12)
    center = (corners * opposite[..., None]).sum(axis=1) / around[:, None]  # of the circle inside
    radius = np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]) / around
    is_wide = (radius >= _RADIUS) & ~is_small
    inward = (center[is_wide, None] - corners[is_wide]) * (_RADIUS / radius[is_wide])[:, None, None]
    return np.concatenate([corners[is_small], corners[is_wide] + inward]).reshape(-1, 2)


def _recorded(seen: Seen, scene: Scene, truth: Truth) -> Faults:
    members = truth.members(truth.filter_of(_FILTERED))
    if members is None or truth.camera is None:
        return
    camera = truth.camera
    matrix = np.array([[camera.fx, 0, camera.cx - 0.5], [0, camera.fy, camera.cy - 0.5], [0, 0, 1]])
    if camera.projection_type == "pinhole" and differs(scene.camera, matrix, relative=1e-6):
        file = scene.file.replace(POSES, CAMERAS)
        yield Fault(file, seen.name, "cam_K [pixels]", text(matrix), text(scene.camera))
    things = [each for each in truth.things(truth.filter_of(_FILTERED)) if each.amodal]
    order = {each.path: index for index, each in enumerate(truth.things(truth.filter_of(_FILTERED)))}
    left = list(things)
    for index, posed in enumerate(scene.objects):
        position = np.array(posed.pose["cam_t_m2c"], np.float64)
        if not left:
            yield Fault(scene.file, seen.name, f"object {index} is not in view")
            continue
        thing = min(left, key=lambda each: float(np.abs(_position(each, truth) - position).max()))
        left.remove(thing)
        what = f"of object {index}, {thing.path}"
        if differs(position, _position(thing, truth), relative=1e-5):
            yield Fault(scene.file, seen.name, f"cam_t_m2c {what} [mm]", text(_position(thing, truth)), text(position))
        number = int(posed.pose["obj_id"])
        if scene.models.class_id(number) not in (None, thing.class_id):
            label = scene.models.label(number)
            yield Fault(scene.file, seen.name, f"obj_id {what} is of its class", thing.label, f"{number}: {label}")
        yield from _turned(seen, scene, what, posed, thing, truth)
        for mask, expected, kind in (
            (posed.visible, members == order[thing.path], "what is visible"), (posed.whole, None, "the whole object")
        ):  # fmt: skip
            if mask is None:
                continue
            if mask.shape != members.shape:
                yield Fault(
                    scene.file, seen.name, f"the mask {what} has another size", str(members.shape), str(mask.shape)
                )
            elif expected is not None and (mask != expected).any():
                yield Fault(
                    scene.masks[2 * index + 1],
                    seen.name,
                    f"the mask of {kind} {what} differs in {of_pixels(mask != expected)}",
                )
            elif expected is None and (int(mask.sum()), extent(mask)) != (thing.amodal, thing.amodal_box):
                yield Fault(
                    scene.masks[2 * index], seen.name, f"pixels and extent of {kind} {what}",
                    f"{thing.amodal} in {thing.amodal_box}", f"{int(mask.sum())} in {extent(mask)}",
                )  # fmt: skip
    for thing in left:
        if thing.visible:
            yield Fault(scene.file, seen.name, f"{thing.path} is visible and is not listed")


def _position(thing: Thing, truth: Truth) -> np.ndarray:
    """Return where the origin of a thing is, in the camera's axes of BOP [mm]."""
    assert truth.camera is not None
    origin = np.append(thing.local_to_world[3, :3], 1.0) @ truth.camera.world_to_camera
    return TO_OPENCV @ origin[:3] * truth.camera.meters_per_unit * MILLIMETERS


def _turned(seen: Seen, scene: Scene, what: str, posed: Posed, thing: Thing, truth: Truth) -> Faults:
    """The rotation is that of the thing's axes, where these are perpendicular and not mirrored."""
    assert truth.camera is not None
    axes = thing.local_to_world[:3, :3] / np.linalg.norm(thing.local_to_world[:3, :3], axis=1, keepdims=True)
    if np.abs(axes @ axes.T - np.eye(3)).max() > 1e-5 or np.linalg.det(axes) < 0:
        return
    expected = TO_OPENCV @ truth.camera.world_to_camera[:3, :3].T @ axes.T
    found = np.array(posed.pose["cam_R_m2c"], np.float64).reshape(3, 3)
    if differs(found, expected, relative=0.0, absolute=1e-4):
        yield Fault(scene.file, seen.name, f"cam_R_m2c {what}", text(expected), text(found))
