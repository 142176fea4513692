"""Reader of YCBVideoWriter's folders."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

import numpy as np

from usdsdg.datasets.color_images import read_color
from usdsdg.datasets.faults import Fault
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.matching import truth_of
from usdsdg.datasets.seen import Depth, Seen
from usdsdg.datasets.seen_object import SeenObject

NAME = "YCBVideoWriter"
_FILE = re.compile(
    r"^(?P<number>\d{6})-(?:(?P<kind>color|depth|label)\.(?:png|jpe?g)|(?P<text>box)\.txt|(?P<mat>meta)\.mat)$"
)
_LIST = "train.txt"
# Folders of pictures of several render products.
_KINDS = ("rgb", "distance_to_image_plane", "semantic_segmentation", "bounding_box_2d_tight")
_NEEDED = ("cls_indexes", "poses", "center", "factor_depth", "intrinsic_matrix")


@dataclass(frozen=True)
class Meta:
    """What a `-meta.mat` says. Exact files have a map of model points."""

    file: str
    indices: np.ndarray  # (n,) of classes
    poses: np.ndarray  # (n, 3, 4)
    centers: np.ndarray  # (n, 2) [pixels]
    factor: int
    matrix: np.ndarray  # (3, 3)
    to_camera: np.ndarray | None  # (3, 4) from the world
    points: np.ndarray | None  # (H, W, 3) on the models [m]

    @property
    def exact(self) -> bool:
        """Whether the numbers are those of `exact=True`."""
        return self.points is not None


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the files of each image say."""
    found: dict[tuple[str, str, str], dict[str, str]] = {}
    for file in files:
        path = PurePosixPath(file)
        match = _FILE.match(path.name)
        if match and len(path.parts) > 1:
            where = path.parent.parent if path.parent.name in _KINDS else path.parent
            # Below the folder of the video, which has a number for a name, there may be one of a render product.
            video, view = (where, "") if where.name.isdigit() else (where.parent, where.name)
            kind = match["kind"] or match["text"] or match["mat"]
            found.setdefault((video.as_posix(), view, match["number"]), {})[kind] = file
    for (video, view, number), parts in sorted(found.items()):
        yield _seen(folder, PurePosixPath(video).name, view, number, parts)
    _check_lists(folder, {(video, number) for video, _, number in found})


def _check_lists(folder: Folder, frames: set[tuple[str, str]]) -> None:
    """Note what a list of frames names that is not there, and the reverse."""
    for root in sorted({PurePosixPath(video).parent.parent for video, _ in frames}):
        file = (root / _LIST).as_posix()
        text = folder.text(file, "all")
        if text is None:
            continue
        listed = text.split()
        there = sorted(
            f"{PurePosixPath(video).name}/{number}" for video, number in frames
            if PurePosixPath(video).parent.parent == root
        )  # fmt: skip
        for name in sorted(set(listed) ^ set(there)):
            what = f"{name} is not there" if name in listed else f"does not list {name}"
            folder.faults.append(Fault(file, name.rpartition("/")[2], what))


def _seen(folder: Folder, video: str, view: str, number: str, parts: dict[str, str]) -> Seen:
    files = list(parts.values())
    seen = Seen(NAME, f"{video}/{number}", view, files, truth_of(folder, files, view))
    seen.picture, seen.labels = parts.get("color", ""), parts.get("box") or parts.get("meta", "")
    if seen.picture:
        seen.size = folder.image_size(seen.picture, seen.name)
    if "box" in parts and (text := folder.text(parts["box"], seen.name)) is not None:
        seen.lines.append((parts["box"], [line.rsplit(" ", 4) for line in text.splitlines()]))
    meta = folder.binary(parts["meta"], seen.name, lambda data: _meta(parts["meta"], data)) if "meta" in parts else None
    if meta is not None:
        seen.extra["meta"] = meta
        seen.variant = "exact" if meta.exact else ""
    factor = meta.factor if meta else int(_parameter(seen, "factor_depth") or 10000)
    seen.later(lambda made: _read_images(folder, made, parts, factor))
    return seen


def _parameter(seen: Seen, name: str) -> Any:
    return seen.truth.record.parameters.get(name) if seen.truth else None


def _meta(file: str, data: bytes) -> Meta:
    from scipy.io import loadmat

    values: Mapping[str, Any] = loadmat(io.BytesIO(data))
    if missing := [name for name in _NEEDED if name not in values]:
        raise ValueError(f"{', '.join(missing)} is not in it")
    poses = values["poses"]
    indices = values["cls_indexes"].ravel().astype(int)
    # MATLAB drops the last dimension of one object.
    poses = poses.reshape(3, 4, -1) if poses.size else np.zeros((3, 4, 0))
    to_camera = values.get("rotation_translation_matrix")
    return Meta(
        file,
        indices,
        np.moveaxis(poses.astype(np.float64), -1, 0),
        values["center"].astype(np.float64).reshape(-1, 2),
        int(values["factor_depth"].ravel()[0]),
        values["intrinsic_matrix"].astype(np.float64).reshape(3, 3),
        None if to_camera is None else to_camera.astype(np.float64).reshape(3, 4),
        values.get("vertmap"),
    )


def _read_images(folder: Folder, seen: Seen, parts: Mapping[str, str], factor: int) -> None:
    if "color" in parts:
        read_color(folder, seen, parts["color"])
    if "label" in parts and (image := folder.image(parts["label"], seen.name)) is not None:
        seen.extra["label"] = (parts["label"], image)
    if "depth" in parts and (image := folder.image(parts["depth"], seen.name)) is not None:
        if image.dtype == np.uint8:
            seen.extra["inverse depth"] = (parts["depth"], image)
        else:
            meters = np.where(image == 0, np.inf, image.astype(np.float64) / factor)
            seen.depths.append(Depth(parts["depth"], "plane", meters, 1 / factor, 0xFFFF / factor))


def objects(seen: Seen) -> list[SeenObject]:
    """Return the objects of the boxes."""
    made = []
    for _, lines in seen.lines:
        for name, *corners in lines:
            left, top, right, bottom = (float(each) for each in corners)
            made.append(SeenObject(name, box=(left, top, right + 1, bottom + 1)))
    return made
