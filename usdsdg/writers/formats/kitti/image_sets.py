"""The list of the pictures of a part of a KITTI dataset in KITTI's own layout."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from usdsdg.writers.aggregate import Aggregate, Texts
from usdsdg.writers.formats.kitti import files
from usdsdg.writers.spool import Records


class ImageSet(Aggregate):
    """A list with the number of a picture in each line.

    A record has the "number" of a picture. Of all frames is known the name of the part, "split".
    """

    @staticmethod
    def files(records: Records) -> dict[str, Texts]:
        return {files.image_set(records.about["split"]): partial(_lines, records)}


def _lines(records: Records) -> Iterator[str]:
    return (f"{each['number']:0{files.PLAIN.digits}d}\n" for each in records)
