"""The lists of pictures of a part of a Pascal VOC dataset: all of them, and which of them show a class."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial

from usdsdg.writers.aggregate import Aggregate, Texts
from usdsdg.writers.formats.voc import files
from usdsdg.writers.formats.voc.voc_xml import VocObject
from usdsdg.writers.spool import Records

SHOWN, NOT_SHOWN, ONLY_DIFFICULT = 1, -1, 0


class ImageSets(Aggregate):
    """Lists with a name in each line; those of a class also have 1, -1 or, if all its objects are difficult, 0.

    A record has the "stem" of a picture, and by class in "shown" 1 or 0. Of all frames are known the name of the part,
    "split", and all "classes".
    """

    @staticmethod
    def files(records: Records) -> Mapping[str, Texts]:
        split = records.about["split"]
        folders = (files.MAIN, files.SEGMENTATION)
        return {files.image_set(folder, split): partial(_stems, records) for folder in folders} | {
            files.image_set(files.MAIN, split, name): partial(_lines, records, name)
            for name in records.about["classes"]
        }


def shown(objects: Sequence[VocObject]) -> dict[str, int]:
    """Return whether objects of each class are shown: SHOWN, or ONLY_DIFFICULT."""
    found: dict[str, int] = {}
    for each in objects:
        found[each.name] = max(found.get(each.name, ONLY_DIFFICULT), ONLY_DIFFICULT if each.difficult else SHOWN)
    return found


def _stems(records: Records) -> Iterator[str]:
    return (f"{each['stem']}\n" for each in records)


def _lines(records: Records, name: str) -> Iterator[str]:
    return (f"{each['stem']} {each['shown'].get(name, NOT_SHOWN):2d}\n" for each in records)
