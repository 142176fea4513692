"""Columns of Parquet shards, with the features by which Hugging Face `datasets` decodes them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from usdsdg.errors import Unsupported
from usdsdg.writers.formats.shards.shard_files import FACTS, IMAGE, INSTANCES, OBJECT

_METADATA = b"huggingface"
_CLASSES = b"usdsdg_classes"  # where several classes have one name, which `datasets` does not read
_TYPES: Mapping[str, str] = {
    "key": "string", "frame": "int64", "view": "string", "width": "int32", "height": "int32",
    "id": "int64", "label": "string", "area": "int64", "visibility": "float32", "path": "string",
}  # fmt: skip


def pyarrow() -> Any:
    """Return pyarrow with its module for Parquet.

    Raises:
        Unsupported: it is not installed.
    """
    try:
        import pyarrow  # pyright: ignore[reportMissingImports]
        import pyarrow.parquet  # pyright: ignore[reportMissingImports]
    except ImportError as error:
        reason = f"Parquet needs pyarrow, which is not installed ({error}): pip install 'usdsdg[parquet]'."
        raise Unsupported(reason) from error
    return pyarrow


def schema(classes: Sequence[str], *, masks: bool) -> Any:
    """Return the pyarrow schema of a shard: the facts of a sample, its images, and a list for each fact of objects.

    `category` is a ClassLabel of `classes`, of which those that have the name of an earlier one get a number, too.
    """
    arrow = pyarrow()
    image = arrow.struct([("bytes", arrow.binary()), ("path", arrow.string())])
    plain = {"string": arrow.string(), "int64": arrow.int64(), "int32": arrow.int32(), "float32": arrow.float32()}
    special = {"bbox": arrow.list_(arrow.float32(), 4), "category": arrow.int64()}
    objects = [(name, arrow.list_(special.get(name) or plain[_TYPES[name]])) for name in OBJECT]
    images = [IMAGE, INSTANCES] if masks else [IMAGE]
    columns = [
        *((name, plain[_TYPES[name]]) for name in FACTS),
        *((name, image) for name in images),
        ("objects", arrow.struct(objects)),
    ]
    names = _told_apart(classes)
    metadata = {_METADATA: json.dumps(_features(names, images)).encode()}
    if names != list(classes):
        metadata[_CLASSES] = json.dumps(list(classes)).encode()
    return arrow.schema(columns).with_metadata(metadata)


def _told_apart(classes: Sequence[str]) -> list[str]:
    """Return names of which none is there twice: labels of several types may have one text."""
    found: dict[str, None] = {}
    for name in classes:
        number = 1
        while (own := name if number == 1 else f"{name} ({number})") in found:
            number += 1
        found[own] = None
    return list(found)


def _features(classes: Sequence[str], images: Sequence[str]) -> dict[str, Any]:
    """Return what `datasets` writes of the columns; "Sequence" is a list to all of its versions."""

    def value(name: str) -> dict[str, Any]:
        return {"dtype": _TYPES[name], "_type": "Value"}

    special: dict[str, Any] = {
        "bbox": {"feature": {"dtype": "float32", "_type": "Value"}, "length": 4, "_type": "Sequence"},
        "category": {"names": list(classes), "_type": "ClassLabel"},
    }
    features: dict[str, Any] = {name: value(name) for name in FACTS}
    features |= {name: {"_type": "Image"} for name in images}
    features["objects"] = {name: {"feature": special.get(name) or value(name), "_type": "Sequence"} for name in OBJECT}
    return {"info": {"features": features}}


def classes_of(known: Any) -> list[str]:
    """Return the names of classes in the metadata of a schema."""
    metadata = known.metadata or {}
    if _CLASSES in metadata:
        return json.loads(metadata[_CLASSES])
    features = json.loads(metadata.get(_METADATA, b"{}"))
    return features["info"]["features"]["objects"]["category"]["feature"]["names"]
