"""The JSON files of a part of a COCO dataset: boxes, masks and keypoints, and segments."""

import json
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

from usdsdg.writers.aggregate import Aggregate, Texts, separated
from usdsdg.writers.spool import Records

INSTANCES, PANOPTIC = "instances", "panoptic"


class CocoFiles(Aggregate):
    """Images with their annotations, and with their segments where there is a panoptic form.

    A record has "image", its "split", and lists of what the files have of it: "instances" and "panoptic". Of all frames
    are known "head", the sections before the images, and by split and file its "path", its "categories", and those that
    it has "if_used" by an object of the dataset.
    """

    @staticmethod
    def files(records: Records) -> dict[str, Texts]:
        return {
            about["path"]: partial(_texts, records, split, about, name)
            for split, tables in records.about["splits"].items()
            for name, about in tables.items()
        }


def _texts(records: Records, split: str, about: Mapping[str, Any], table: str) -> Iterator[str]:
    """Yield the JSON, with one line per record."""
    yield "{\n"
    for key, value in records.about["head"].items():
        yield f"{json.dumps(key)}: {json.dumps(value)},\n"
    yield '"images": [\n'
    yield from separated(json.dumps(each["image"]) for each in records if each["split"] == split)
    yield '\n],\n"annotations": [\n'
    rows = (
        _numbered(records) if table == INSTANCES else ((each["split"], row) for each in records for row in each[table])
    )
    yield from separated(json.dumps(row) for own, row in rows if own == split)
    yield '\n],\n"categories": [\n'
    yield from separated(map(json.dumps, _categories(records, about, table)))
    yield "\n]\n}\n"


def _categories(records: Records, about: Mapping[str, Any], table: str) -> list[Any]:
    """Return the categories by id; of those that are listed if used, those that an object of any split has."""
    reserve = about.get("if_used") or []
    if reserve:
        rows = (row for each in records for row in each[table])
        things = (thing for row in rows for thing in (row["segments_info"] if table == PANOPTIC else [row]))
        used = {thing["category_id"] for thing in things}
        reserve = [each for each in reserve if each["id"] in used]
    return sorted([*about["categories"], *reserve], key=lambda each: each["id"])


def _numbered(records: Records) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the split of each annotation, and the annotation with an id that no split has twice."""
    number = 0
    for each in records:
        for row in each[INSTANCES]:
            number += 1  # from 1, since COCO's evaluation treats id 0 as no match
            yield each["split"], {"id": number} | row
