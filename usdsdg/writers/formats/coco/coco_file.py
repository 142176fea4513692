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

    A record has "image", and lists of what the files have of it: "instances" and "panoptic". Of all frames are known
    "head", the sections before the images, and by file its "path" and "categories".
    """

    @staticmethod
    def files(records: Records) -> dict[str, Texts]:
        tables = {name: records.about[name] for name in (INSTANCES, PANOPTIC) if name in records.about}
        return {
            about["path"]: partial(_texts, records, records.about["head"], about["categories"], name)
            for name, about in tables.items()
        }


def _texts(records: Records, head: Mapping[str, Any], categories: list[Any], table: str) -> Iterator[str]:
    """Yield the JSON, with one line per record."""
    yield "{\n"
    for key, value in head.items():
        yield f"{json.dumps(key)}: {json.dumps(value)},\n"
    yield '"images": [\n'
    yield from separated(json.dumps(each["image"]) for each in records)
    yield '\n],\n"annotations": [\n'
    yield from separated(json.dumps(row) for each in records for row in each[table])
    yield '\n],\n"categories": [\n'
    yield from separated(map(json.dumps, categories))
    yield "\n]\n}\n"
