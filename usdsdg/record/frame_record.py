"""The record of one frame: what was in view, from the AOVs and the stage, not from what writers were handed."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import PurePath
from typing import Any, NamedTuple

import numpy as np

from usdsdg.record import cameras, id_runs, npz
from usdsdg.stage.cameras.camera_view import CameraView

# 1 had a member of the file for each array; before 3 the stage names assets by where they were on their machine.
VERSION = 3
# Distance of the pixels of the grids of depth and normals, and sides of the blocks that a thumbnail averages.
STEP, BLOCK = 8, 16

OPAQUE = "LdrColor without alpha"  # a checksum, of images that are transparent somewhere

Labels = Mapping[str, Any]  # {type: [label, ...]}, or as annotators output them {type: "label[,label]"}


@dataclass(frozen=True)
class SelectionRecord:
    """The prims that one label filter selects, with the ids that a frame gives them."""

    rows: np.ndarray  # (K,) int: rows of the prims of the product
    ids: np.ndarray  # (K,) int: in instance_segmentation
    class_ids: np.ndarray  # (K,) int: in semantic_segmentation
    labels: tuple[dict[str, str], ...]  # K times {type: "label[,label]"}
    member_of_gprim: np.ndarray  # (G,) int: index into rows, -1 for gprims of no selected prim


class KeypointRecord(NamedTuple):
    """The keypoints of one prim that is not hidden."""

    owners: Mapping[str, str]  # by label filter: the nearest prim above it that this selects
    names: tuple[str, ...]
    positions: np.ndarray  # (K, 3) in the world [stage units]


@dataclass(frozen=True)
class ProductRecord:
    """What one render product showed. Of prims those that are in view, hidden ones too, have a row."""

    name: str
    path: str
    size: tuple[int, int]  # width, height
    cameras: tuple[CameraView, ...]  # one, or those of its tiles
    columns: int = 1  # of tiles
    gprims: tuple[str, ...] = ()  # those that are visible
    prims: tuple[str, ...] = ()
    labels: tuple[Labels, ...] = ()  # of the prims, own and inherited, outermost first
    bounds: np.ndarray = field(default_factory=lambda: np.zeros((0, 2, 3)))  # in the prim's frame [stage units]
    local_to_world: np.ndarray = field(default_factory=lambda: np.zeros((0, 4, 4)))  # for row vectors
    amodal: np.ndarray | None = None  # (N, 5): pixels, x_min, y_min, x_max, y_max (inclusive); None: not rendered
    selections: Mapping[str, SelectionRecord] = field(default_factory=dict)  # by filter, "" lets every label pass
    runs: tuple[np.ndarray, np.ndarray] | None = None  # of the image of visible gprims; None: not rendered
    depth: np.ndarray | None = None  # distance_to_camera [m] of every STEP-th pixel
    normals: np.ndarray | None = None  # of every STEP-th pixel, int8 in steps of 1/127
    keypoints: tuple[KeypointRecord, ...] = ()  # where an annotator reads them
    thumbnail: np.ndarray | None = None  # uint8 (h, w, 3): means of blocks of the color image
    checksums: Mapping[str, int] = field(default_factory=dict)  # CRC-32 of whole AOVs, by name

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width [pixels]."""
        return self.size[1], self.size[0]

    @cached_property
    def gprim_image(self) -> np.ndarray | None:
        """The visible gprim of each pixel, int32 (H, W), -1 for none; None if there is no such image."""
        return None if self.runs is None else id_runs.decode(*self.runs, self.shape)


@dataclass(frozen=True)
class FrameRecord:
    """One frame of one writer."""

    number: int  # as the writer counts: how many it had received before
    writer: str  # its class
    products: tuple[ProductRecord, ...]
    writer_version: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict)  # of its `initialize`, as JSON has them
    annotators: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)  # by name: template, filter, params
    files: tuple[str, ...] = ()  # that it scheduled for this frame, as far as its backend knows
    seconds: float = 0.0  # on the timeline
    capture: int = 0  # number of earlier captures of the process
    seed: int | None = None
    up_axis: str = "Z"
    stable_ids: bool = True  # whether ids of classes are the same in all frames
    semantic_classes: Mapping[str, int] = field(default_factory=dict)  # those that the user has fixed, with their ids
    stage: Mapping[str, Any] = field(default_factory=dict)  # file of the stage, time code, settings; {}: not recorded
    edits: bytes = b""  # text of a layer: what has changed on that stage
    version: int = VERSION  # of the form of records, 1 where usdsdg 0.1 wrote it


def encode(record: FrameRecord) -> bytes:
    """Return the bytes of the record's file."""
    facts = {name: getattr(record, name) for name in _FACTS}
    arrays: dict[str, np.ndarray] = {}
    products = []
    for index, product in enumerate(record.products):
        described, own = _encoded(product)
        products.append(described)
        arrays |= {f"{index}_{name}": array for name, array in own.items()}
    if record.edits:
        arrays["edits"] = np.frombuffer(record.edits, np.uint8)
    packed, places = npz.packed(arrays)
    text = json.dumps(
        {"version": VERSION, **facts, "products": products, "arrays": places},
        separators=(",", ":"), default=_plain, skipkeys=True,
    )  # fmt: skip
    return npz.encode({"facts": np.frombuffer(text.encode(), np.uint8), "arrays": packed})


def decode(data: bytes) -> FrameRecord:
    """Return the record of a file's bytes.

    Raises:
        ValueError, KeyError, TypeError, OSError, zipfile.BadZipFile: they are no record, or damaged.
    """
    arrays = npz.decode(data)
    facts = json.loads(arrays["facts"].tobytes())
    if facts["version"] > VERSION:
        raise ValueError(f"it is of version {facts['version']}, and this program reads up to {VERSION}")
    if facts["version"] > 1:
        arrays = npz.unpacked(arrays["arrays"], facts["arrays"])
    products = []
    for index, described in enumerate(facts["products"]):
        own = {name.split("_", 1)[1]: array for name, array in arrays.items() if name.startswith(f"{index}_")}
        products.append(_decoded(described, own))
    known = {name: facts[name] for name in _FACTS if name in facts}
    edits = arrays["edits"].tobytes() if "edits" in arrays else b""
    known |= {"files": tuple(facts["files"]), "version": int(facts["version"])}
    return FrameRecord(**{**known, "products": tuple(products), "edits": edits})


_FACTS = (
    "number", "writer", "writer_version", "parameters", "annotators", "files", "seconds", "capture", "seed", "up_axis",
    "stable_ids", "semantic_classes",
    "stage",
)  # fmt: skip


def _plain(value: Any) -> Any:
    """Return what JSON has of a value that it does not know: the same in all processes."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    return value.as_posix() if isinstance(value, PurePath) else type(value).__name__


def _encoded(product: ProductRecord) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return a product as values for JSON, and as arrays by name."""
    values: dict[str, Any] = {
        "name": product.name, "path": product.path, "size": product.size, "columns": product.columns,
        "cameras": [cameras.described(view) for view in product.cameras], "gprims": product.gprims,
        "prims": product.prims, "labels": product.labels, "checksums": product.checksums,
        "selections": {key: list(each.labels) for key, each in product.selections.items()},
    }  # fmt: skip
    arrays: dict[str, np.ndarray | None] = {
        "bounds": product.bounds.astype(np.float32),
        # The last column is always 0 0 0 1.
        "local_to_world": product.local_to_world[:, :, :3].astype(np.float32),
        "amodal": None if product.amodal is None else product.amodal.astype(np.int32),
        "depth": product.depth,
        "normals": product.normals,
        "thumbnail": product.thumbnail,
    }
    if product.keypoints:
        values["keypoints"] = [[each.owners, each.names] for each in product.keypoints]
        arrays["keypoints"] = np.concatenate([each.positions for each in product.keypoints]).astype(np.float32)
    if product.runs is not None:
        arrays["run_ids"], arrays["run_lengths"] = product.runs
    for index, each in enumerate(product.selections.values()):
        arrays[f"selected_{index}"] = np.stack([each.rows, each.ids, each.class_ids]).astype(np.int32)
        arrays[f"members_{index}"] = each.member_of_gprim.astype(np.int32)
    return values, {name: array for name, array in arrays.items() if array is not None}


def _decoded(values: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> ProductRecord:
    selections = {}
    for index, (key, labels) in enumerate(values["selections"].items()):
        rows, ids, class_ids = arrays[f"selected_{index}"]
        selections[key] = SelectionRecord(rows, ids, class_ids, tuple(labels), arrays[f"members_{index}"])
    poses = np.zeros((len(values["prims"]), 4, 4))
    poses[:, :, :3] = arrays["local_to_world"]
    poses[:, 3, 3] = 1.0
    return ProductRecord(
        values["name"], values["path"], tuple(values["size"]), tuple(map(cameras.camera, values["cameras"])),
        values["columns"], tuple(values["gprims"]), tuple(values["prims"]), tuple(values["labels"]),
        arrays["bounds"].astype(np.float64), poses, arrays.get("amodal"), selections,
        (arrays["run_ids"], arrays["run_lengths"]) if "run_ids" in arrays else None,
        arrays.get("depth"), arrays.get("normals"), _keypoints(values, arrays), arrays.get("thumbnail"),
        values["checksums"],
    )  # fmt: skip


def _keypoints(values: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> tuple[KeypointRecord, ...]:
    found, start = [], 0
    for owners, names in values.get("keypoints", ()):
        positions = arrays["keypoints"][start : start + len(names)].astype(np.float64)
        found.append(KeypointRecord(owners, tuple(names), positions))
        start += len(names)
    return tuple(found)
