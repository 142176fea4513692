"""`train.txt` of YCB-Video: the names of the frames that there are."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from usdsdg.writers.aggregate import Aggregate, Texts
from usdsdg.writers.spool import Records

ROOT, VIDEO = "data/YCB_Video", "0000"
LIST = f"{ROOT}/train.txt"


class TrainList(Aggregate):
    """The name of a frame in each line. A record has the "number" of a frame; "list" is the path of the file."""

    @staticmethod
    def files(records: Records) -> dict[str, Texts]:
        return {records.about["list"]: partial(_names, records)}


def frame_name(number: int) -> str:
    """Return a line of the list."""
    return f"{VIDEO}/{number:06d}\n"


def _names(records: Records) -> Iterator[str]:
    return (frame_name(each["number"]) for each in records)
