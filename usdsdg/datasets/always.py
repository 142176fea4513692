"""The files that a dataset of a format always has beside those that single frames wrote."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import PurePosixPath

from usdsdg.record import CLASSES
from usdsdg.record.frame_record import FrameRecord
from usdsdg.writers.formats.bop import bop_files
from usdsdg.writers.formats.coco import files as coco_files
from usdsdg.writers.formats.cvat import files as cvat_files
from usdsdg.writers.formats.shards import shard_files
from usdsdg.writers.formats.voc import files as voc_files
from usdsdg.writers.formats.yolo import yolo_files

_COCO = "CocoWriter"
_BY_WRITER: Mapping[str, tuple[str, ...]] = {
    bop_files.NAME: (bop_files.CAMERA, bop_files.MODELS_INFO),
    cvat_files.NAME: (cvat_files.ANNOTATIONS, cvat_files.LABELS),
    shard_files.WEBDATASET: (shard_files.INDEX,),
    voc_files.NAME: (voc_files.LABELS,),
    yolo_files.NAME: (yolo_files.DESCRIPTION,),
}


def always(records: Iterable[FrameRecord]) -> list[str]:
    """Return the files about all frames that a finished dataset has, by the records of its frames."""
    found: dict[str, None] = {}
    for record in records:
        found |= dict.fromkeys(_BY_WRITER.get(record.writer, ()))
        if record.writer == bop_files.NAME and record.version > 1:  # 0.1 had no names
            found[bop_files.MODEL_NAMES] = None
        if record.writer == _COCO:
            found |= dict.fromkeys(_of_coco(record))
        # The table of classes is of what the annotators' filters select; a dataset with no such annotator has none.
        if record.stable_ids and any(each.get("filter") for each in record.annotators.values()):
            found[CLASSES] = None
    return list(found)


def _of_coco(record: FrameRecord) -> Iterable[str]:
    """Yield the JSON files that list what a frame wrote."""
    options = record.parameters
    plain = options.get("plain_names")
    if plain or (plain is None and options.get("splits") is not None):
        splits = {path.parts[0] for file in record.files if len((path := PurePosixPath(file)).parts) == 2}
        listed = [coco_files.PlainNames(split) for split in sorted(splits)]
    else:  # Replicator's names, of which the seed is a part
        listed = [coco_files.ReplicatorNames(options.get("dataset_id") or coco_files.id_of_seed(record.seed))]
    for names in listed:
        yield names.instances
        if options.get("panoptic"):
            yield names.panoptic
