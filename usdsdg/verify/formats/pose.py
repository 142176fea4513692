"""Reader of PoseWriter's files, in its three formats."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from usdsdg.inspect.read_pose import FILE, view_of
from usdsdg.record.frame_record import FrameRecord, ProductRecord
from usdsdg.verify.folder import Folder
from usdsdg.verify.formats.matching import record_of
from usdsdg.verify.seen import Camera, Color, Posed, Poses, Seen
from usdsdg.verify.truth import Truth

NAME = "PoseWriter"
BOXES = "bounding_box_3d_fast"
_ROUNDED = 1e-5


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the files of each image say."""
    found: dict[tuple[str, str], dict[str, str]] = {}
    for file in files:
        match = FILE.match(PurePosixPath(file).name)
        if match:
            kind = "json" if match["kind"].lower() == "json" else "picture"
            found.setdefault((view_of(Path(file)), match["number"]), {})["overlay" if match["overlay"] else kind] = file
    views = {view for (view, _), parts in found.items() if "json" in parts}
    for (view, number), parts in sorted(found.items()):
        if view in views:
            yield _seen(folder, view, number, parts)


def _seen(folder: Folder, view: str, number: str, parts: dict[str, str]) -> Seen:
    seen = Seen(NAME, number, view, list(parts.values()))
    record = record_of(folder, seen.files)
    if record is not None:
        product = _product(record, view, seen.files)
        seen.truth = None if product is None else Truth(record, product)
    if "picture" in parts and (image := folder.image(parts["picture"], seen.name)) is not None:
        seen.colors.append(Color(parts["picture"], image, exact=parts["picture"].lower().endswith(".png")))
        seen.size = (image.shape[1], image.shape[0])
    values = folder.json(parts["json"], seen.name) if "json" in parts else None
    if values is not None:
        folder.parsed(parts["json"], seen.name, lambda: _read_objects(seen, parts["json"], values))
    return seen


def _product(record: FrameRecord, view: str, files: list[str]) -> ProductRecord | None:
    """Return the product that an image shows: by its folder, else by its place among those with objects."""
    named = next((each for each in record.products if each.name == view.split("/")[-1]), None)
    if named is not None or len(record.products) == 1:
        return named or record.products[0]
    stems = list(dict.fromkeys(Path(file).stem for file in record.files if file.endswith(".json")))
    drawn = list(record.products)
    if len(stems) < len(drawn):
        threshold = float(record.parameters.get("visibility_threshold") or 0.0)
        drawn = [each for each in drawn if expected(Truth(record, each), threshold)]
    place = next((stems.index(Path(file).stem) for file in files if Path(file).stem in stems), None)
    return drawn[place] if place is not None and place < len(drawn) else None


def expected(truth: Truth, threshold: float) -> list[Any]:
    """Return the things that PoseWriter lists: those of which a larger fraction is visible."""
    things = truth.things(truth.filter_of(BOXES, "class:*"))
    return [each for each in things if each.occlusion is not None and 1.0 - np.float32(each.occlusion) > threshold]


def _read_objects(seen: Seen, file: str, values: Mapping[str, Any]) -> None:
    parameters = seen.truth.record.parameters if seen.truth else {}
    order, camera = list(values["keypoint_order"]), values["camera_data"]
    kind = "dope" if order[0] != "Center" else "default" if "resolution" in camera else "centerpose"
    objects = [
        Posed(each["prim_path"], str(each.get("label", each.get("class"))), float(each["visibility"]), each)
        for each in values["objects"]
    ]
    exact = bool(parameters.get("exact_camera_frame"))
    seen.poses.append(Poses(file, objects, order, kind, exact, float(parameters.get("visibility_threshold") or 0.0)))
    intrinsics = camera["intrinsics"]
    size = camera.get("resolution") or ([camera["width"], camera["height"]] if "width" in camera else None)
    seen.cameras.append(
        Camera(
            file, np.array(camera["camera_view_matrix"], np.float64), _ROUNDED,
            None if size is None else (int(size[0]), int(size[1])), float(intrinsics["fx"]),
            (float(intrinsics["cx"]), float(intrinsics["cy"])), camera,
        )
    )  # fmt: skip
