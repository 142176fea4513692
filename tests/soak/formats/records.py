"""What the records of a dataset's frames say was in each picture, as files that any Python reads."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from tests.soak.formats import readers
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.reading import images
from usdsdg.datasets.truth import Thing, Truth
from usdsdg.verify import verify

LIMITS = ("visibility", "pixels")  # least ones, which options of writers set
BOXES = "bounding_box_2d_tight_fast"
# Of the scene's cameras, which have USD's default lens: focal length by the width of the picture.
FOCAL = 50.0 / 20.955


def rows_of(script: str, folder: Path, datasets: Mapping[str, list]) -> Iterator[tuple[str, str, bool]]:
    """Yield what a script of `readers`, and `usdsdg verify`, say of datasets below a folder.

    datasets: further arguments of the script by the name of the dataset.
    """
    for name, more in datasets.items():
        for what, found, is_right in readers.rows_of(script, folder / name, *record(folder / name, folder), *more):
            yield f"{name}: {what}", found, is_right
        report = verify(folder / name)
        yield f"{name}: usdsdg verify", report.summary(), report.is_clean and not report.notes


def record(dataset: Path, folder: Path) -> tuple[Path, Path]:
    """Write what is recorded of a dataset; return the two files, `objects.json` and `ids.npz`.

    objects.json has, by the file of a picture, a list of the objects in view, each with `name`, `instance` (its id in
    instance_segmentation), `box` (first and last column and row), `pixels` (visible ones), `hidden` (the fraction of
    its pixels behind others), `outside` (the fraction of the rectangle around its 3D box outside of the picture) and
    `corners` (8 of its 3D box, in meters from the camera: x right, y down, z ahead). ids.npz has, by the same names,
    the object of each pixel, as its place in the list from 1, and 0 for none.
    """
    objects, ids = {}, {}
    for seen in images(Folder(dataset), set()):
        assert seen.truth is not None, seen.name
        members = seen.truth.members(seen.truth.filter_of(BOXES))
        assert members is not None, seen.name
        things = seen.truth.things(seen.truth.filter_of(BOXES))
        shown = [index for index, thing in enumerate(things) if thing.visible]
        place = np.zeros(len(things) + 2, np.uint16)
        place[shown] = np.arange(1, len(shown) + 1)
        objects[seen.picture] = [_described(things[index], seen.truth) for index in shown]
        ids[seen.picture] = place[np.maximum(members, -1)]
    where = folder / "objects.json", folder / "ids.npz"
    where[0].write_text(json.dumps(objects))
    np.savez_compressed(where[1], **ids)
    return where


def _described(thing: Thing, truth: Truth) -> dict:
    assert thing.amodal is not None
    corners = _corners(thing, truth)
    return {
        "name": ",".join(label for _, label in sorted(thing.labels.items())),
        "instance": thing.id,
        "box": thing.box,
        "pixels": thing.visible,
        "hidden": 1.0 - thing.visible / thing.amodal,
        "outside": _outside(corners, truth.product.size),
        "corners": corners.tolist(),
    }


def _corners(thing: Thing, truth: Truth) -> np.ndarray:
    assert truth.camera is not None
    signs = np.stack(np.meshgrid((0, 1), (0, 1), (0, 1)), axis=-1).reshape(-1, 3)
    local = np.where(signs, thing.bounds[1], thing.bounds[0])
    points = np.c_[local, np.ones(8)] @ thing.local_to_world @ np.linalg.inv(truth.camera.local_to_world)
    return points[:, :3] * (1.0, -1.0, -1.0) * truth.camera.meters_per_unit


def _outside(corners: np.ndarray, size: tuple[int, int]) -> float:
    assert (corners[:, 2] > 0).all()  # the scene is in front of its cameras
    pixels = corners[:, :2] / corners[:, 2:] * FOCAL * size[0] + np.array(size) / 2
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    inside = np.clip(high, 0, size) - np.clip(low, 0, size)
    return float(1.0 - inside.prod() / (high - low).prod())
