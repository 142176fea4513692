"""Reader of BasicWriter's folders: files per annotator and frame, flat or in a folder per render product."""

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from usdsdg.datasets import cuboids
from usdsdg.datasets.cuboids import CORNERS, CurvedCamera, PinholeCamera
from usdsdg.datasets.formats.basic import BOXES, DEPTHS, FILE, PICTURES, SHOWN, view_of
from usdsdg.datasets.seen_object import SeenObject
from usdsdg.errors import AssetError, Unsupported
from usdsdg.inspect.listing import UNREADABLE, read_array, read_json
from usdsdg.inspect.records import Dataset, Frame, Problem
from usdsdg.stage.cameras.lenses import LENS_MODELS
from usdsdg.writers.formats.shapes.camera_projection import lens_of

LOOKED_FOR = "BasicWriter's rgb_NNNN.png, bounding_box_2d_tight_NNNN.npy and the like"

Parts = dict[str, Path]
# Camera, meters per unit and image size.
Seen = tuple[PinholeCamera | CurvedCamera, float, tuple[int, int]]


def read(dataset: Dataset, files: list[Path]) -> list[Path]:
    """Add BasicWriter's frames among `files` to the dataset; return their files."""
    found: dict[tuple[str, str], Parts] = {}
    mine = []
    for path in files:
        match = FILE.match(path.name)
        if match:
            mine.append(path)
            part = "/".join(filter(None, (match["kind"], match["table"], match["ending"].lower())))
            found.setdefault((view_of(path, match), match["number"]), {})[part] = path
    for (view, number), parts in sorted(found.items()):
        _read_frame(dataset, view, number, parts)
    if found:
        dataset.writers.append("BasicWriter")
        _check_complete(dataset, found)
    return mine


def _picture(parts: Parts, kind: str) -> Path | None:
    return next((parts[f"{kind}/{ending}"] for ending in ("png", "jpg", "jpeg") if f"{kind}/{ending}" in parts), None)


def _read_frame(dataset: Dataset, view: str, number: str, parts: Parts) -> None:
    for part in parts:
        kind = part.split("/")[0]
        if kind not in SHOWN:
            dataset.unshown[kind] = dataset.unshown.get(kind, 0) + 1
    if not any(part.split("/")[0] in SHOWN for part in parts):
        return
    frame = Frame(view, number, _picture(parts, "rgb"))
    dataset.frames.append(frame)
    for kind in PICTURES:
        picture = _picture(parts, kind)
        if picture is not None:
            frame.layers[kind] = picture
    for kind in DEPTHS:
        if f"{kind}/npy" in parts:
            frame.layers[kind] = parts[f"{kind}/npy"]
    try:
        frame.objects = list(_objects(dataset, frame, parts).values())
    except (KeyError, TypeError, ValueError, IndexError) as error:
        said = f"{error} is missing" if isinstance(error, KeyError) else str(error)
        dataset.problems.append(Problem(UNREADABLE, f"{frame.name}: not as BasicWriter writes: {said}", frame.name))


def _objects(dataset: Dataset, frame: Frame, parts: Parts) -> dict[str, SeenObject]:
    """Return objects by prim path, merged from all kinds of boxes."""
    objects: dict[str, SeenObject] = {}
    for kind in BOXES:
        if f"{kind}/npy" not in parts:
            continue
        rows = read_array(dataset, parts[f"{kind}/npy"], frame.name)
        labels = _table(dataset, frame, parts, f"{kind}/labels/json")
        prims = _table(dataset, frame, parts, f"{kind}/prim_paths/json") or []
        if rows is None or labels is None:
            continue
        frame.labeled = True
        camera = _camera(dataset, frame, parts) if kind == "bounding_box_3d" else None
        for index, row in enumerate(rows):
            prim = str(prims[index]) if index < len(prims) else f"{kind}[{index}]"
            seen = objects.setdefault(prim, SeenObject(_label(dataset, frame, labels, row), prim))
            _add_box(seen, kind, row, camera)
    return objects


def _table(dataset: Dataset, frame: Frame, parts: Parts, part: str) -> Any | None:
    if part not in parts:
        kind, table, _ = part.split("/")
        dataset.problems.append(
            Problem("missing file", f"{frame.name}: {kind}_{table}_{frame.number}.json is missing", frame.name)
        )
        return None
    return read_json(dataset, parts[part], frame.name)


def _label(dataset: Dataset, frame: Frame, labels: Mapping[str, Any], row: np.void) -> str:
    """Return the class of a row, or all its labels if it has no class."""
    known = labels.get(str(int(row["semanticId"])))
    if known is None:
        text = f"{frame.name}: a box has id {int(row['semanticId'])}, which the labels file does not know"
        dataset.problems.append(Problem("unknown label", text, frame.name))
        return "?"
    if isinstance(known, Mapping):
        return str(known.get("class") or ", ".join(str(value) for value in known.values()))
    return str(known)


def _add_box(seen: SeenObject, kind: str, row: np.void, camera: Seen | None) -> None:
    occlusion = float(row["occlusionRatio"])
    # -1 means unknown, nan out of view.
    if 0.0 <= occlusion <= 1.0:
        seen.visibility = 1.0 - occlusion
    if kind == "bounding_box_3d":
        if camera is not None:
            _add_cuboid(seen, row, *camera)
        return
    # Pixel bounds are inclusive.
    box = (float(row["x_min"]), float(row["y_min"]), float(row["x_max"]) + 1.0, float(row["y_max"]) + 1.0)
    if kind.endswith("tight"):
        seen.box = box
    else:
        seen.loose = box


def _add_cuboid(
    seen: SeenObject, row: np.void, camera: PinholeCamera | CurvedCamera, meters: float, size: tuple[int, int]
) -> None:
    low, high = (np.array([row[f"{axis}_{end}"] for axis in "xyz"], float) for end in ("min", "max"))
    corners = [[(low if name[axis] in "LDB" else high)[axis] for axis in range(3)] for name in CORNERS]
    local = np.array([(low + high) / 2.0, *corners])
    transform = np.asarray(row["transform"], dtype=float)
    points = camera.to_camera(local @ transform[:3, :3] + transform[3, :3])
    made = cuboids.project_cuboid(points, camera)
    seen.cuboid, seen.edges, seen.axes = made.cuboid, made.edges, made.axes
    seen.distance = float(np.linalg.norm(points[0])) * meters
    drawn = seen.cuboid if seen.cuboid is not None else seen.edges
    if seen.loose is None and seen.box is None and drawn is not None and len(drawn):
        seen.loose = cuboids.bounds(drawn.reshape(-1, 2), size)


def _camera(dataset: Dataset, frame: Frame, parts: Parts) -> Seen | None:
    """Return camera, meters per unit and image size; None if 3D boxes cannot be drawn."""
    if "camera_params/json" not in parts:
        _note(dataset, "Boxes in space are not drawn where camera_params is missing: write it along with them.")
        return None
    values = read_json(dataset, parts["camera_params/json"], frame.name)
    if values is None:
        return None
    model = str(values.get("cameraModel", "pinhole"))
    width, height = (int(part) for part in values["renderProductResolution"])
    view = np.reshape(np.array(values["cameraViewTransform"], float), (4, 4))
    meters = float(values.get("metersPerSceneUnit", 1.0))
    if model in LENS_MODELS:
        try:
            lens = lens_of(values)
        except (AssetError, Unsupported) as problem:
            _note(dataset, f"Boxes in space are not drawn where the texture of the lens is not there: {problem}")
            return None
        if lens is not None:
            return CurvedCamera(lens, view), meters, (width, height)
    if model != "pinhole":
        _note(dataset, f"Boxes in space are not drawn for the camera model {model}.")
        return None
    projection = np.reshape(np.array(values["cameraProjection"], float), (4, 4))
    center = ((1.0 - projection[2, 0]) * width / 2.0, (1.0 + projection[2, 1]) * height / 2.0)
    focal = width * float(values["cameraFocalLength"]) / float(values["cameraAperture"][0])
    return PinholeCamera(focal, center, view), meters, (width, height)


def _note(dataset: Dataset, text: str) -> None:
    if text not in dataset.notes:
        dataset.notes.append(text)


def _check_complete(dataset: Dataset, found: Mapping[tuple[str, str], Parts]) -> None:
    """Check that every frame of a view has the files that most frames of that view have."""
    known = set(dataset.problems)
    for view in {view for view, _ in found}:
        frames = {number: parts for (other, number), parts in found.items() if other == view}
        counts = Counter(part for parts in frames.values() for part in parts)
        usual = {part for part, count in counts.items() if 2 * count > len(frames)}
        for number, parts in sorted(frames.items()):
            name = f"{view}/{number}" if view else number
            for part in sorted(usual - parts.keys()):
                kind = "picture missing" if part.startswith("rgb/") else "missing file"
                file = "_".join([*part.split("/")[:-1], number]) + "." + part.split("/")[-1]
                problem = Problem(kind, f"{name}: {file} is missing", name)
                if problem not in known:
                    dataset.problems.append(problem)
