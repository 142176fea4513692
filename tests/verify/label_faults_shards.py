"""Kinds of label faults of WebDataset and Parquet."""

from __future__ import annotations

import importlib
import io
import json
import tarfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from tests.verify.datasets import DATASETS
from tests.verify.label_faults import edit_json, kind, shift

# WebDataset


def _tars(folder: Path, change: Callable[[str, bytes], bytes | None]) -> None:
    """Change the members of shards, by extension; None leaves a member out."""
    for path in folder.glob("*.tar"):
        with tarfile.open(path) as tar:
            members = [(each, tar.extractfile(each).read()) for each in tar]
        with tarfile.open(path, "w", format=tarfile.USTAR_FORMAT) as tar:
            for member, data in members:
                changed = change(member.name.partition(".")[2], data)
                if changed is not None:
                    member.size = len(changed)
                    tar.addfile(member, io.BytesIO(changed))


def _sampled(folder: Path, change: Callable[[dict], None]) -> None:
    def edit(extension: str, data: bytes) -> bytes:
        if extension == "json":
            values = json.loads(data)
            change(values)
            return json.dumps(values).encode()
        return data

    _tars(folder, edit)


@kind("corners for sizes in boxes of shards", "webdataset")
def _(folder: Path) -> None:
    def corners(values: dict) -> None:
        for each in values["objects"]:
            x, y, width, height = each["bbox"]
            each["bbox"] = [x, y, x + width, y + height]

    _sampled(folder, corners)


@kind("categories of shards counted from 1", "tars")
def _(folder: Path) -> None:
    _sampled(folder, lambda values: [each.update(category=each["category"] + 1) for each in values["objects"]] and None)


@kind("an object of a shard dropped", "tars")
def _(folder: Path) -> None:
    _sampled(folder, lambda values: values["objects"] and values["objects"].pop() and None)


@kind("areas of boxes for those of masks", "webdataset")
def _(folder: Path) -> None:
    def boxed(values: dict) -> None:
        for each in values["objects"]:
            each["area"] = int(each["bbox"][2] * each["bbox"][3])

    _sampled(folder, boxed)


@kind("occlusion for visibility in shards", "tars")
def _(folder: Path) -> None:
    def invert(values: dict) -> None:
        for each in values["objects"]:
            each["visibility"] = 1 - each["visibility"]

    _sampled(folder, invert)


@kind("images of ids one pixel to the right in shards", "webdataset")
def _(folder: Path) -> None:
    def move(extension: str, data: bytes) -> bytes:
        if extension != "instances.png":
            return data
        buffer = io.BytesIO()
        Image.fromarray(shift(np.array(Image.open(io.BytesIO(data))))).save(buffer, "PNG")
        return buffer.getvalue()

    _tars(folder, move)


@kind("a picture of another sample in a shard", "webdataset")
def _(folder: Path) -> None:
    first: list[bytes] = []

    def stale_picture(extension: str, data: bytes) -> bytes:
        if extension != "png":
            return data
        first.append(data)
        return first[0]

    _tars(folder, stale_picture)


@kind("samples missing in a shard", "tars")
def _(folder: Path) -> None:
    (folder / "val-000000.tar").unlink()


@kind("names of classes of shards in another order", "webdataset")
def _(folder: Path) -> None:
    edit_json(folder / "index.json", lambda values: values.update(classes=values["classes"][::-1]))


# Parquet, where pyarrow is installed


def _tables(folder: Path, change: Callable[[dict], None]) -> None:
    """Change the rows of shards."""
    parquet = importlib.import_module("pyarrow.parquet")
    for path in folder.glob("data/*.parquet"):
        table = parquet.read_table(path)
        rows = table.to_pylist()
        for row in rows:
            change(row)
        parquet.write_table(table.from_pylist(rows, schema=table.schema), path)


if "parquet" in DATASETS:

    @kind("centers for corners in boxes of tables", "parquet")
    def _(folder: Path) -> None:
        def centers(row: dict) -> None:
            row["objects"]["bbox"] = [[x + w / 2, y + h / 2, w, h] for x, y, w, h in row["objects"]["bbox"]]

        _tables(folder, centers)

    @kind("labels of tables shifted by one row", "parquet")
    def _(folder: Path) -> None:
        last: list[Any] = []

        def swap(row: dict) -> None:
            last.append(row["objects"])
            row["objects"] = last[max(len(last) - 3, 0)]

        _tables(folder, swap)
