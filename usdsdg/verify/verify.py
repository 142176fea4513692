"""Verification of a dataset: every format's files, every check."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from usdsdg.datasets.attempt import UNREADABLE, attempt, attempt_each
from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.folder import Folder, check_folder
from usdsdg.datasets.parts import parts
from usdsdg.datasets.reading import images
from usdsdg.datasets.seen import Seen
from usdsdg.errors import DatasetError
from usdsdg.record import FRAMES, STAGES
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.verify.checks import (
    arrays,
    boxes,
    camera,
    class_table,
    color,
    depth,
    drawn,
    ids,
    points,
    poses,
    solids,
)
from usdsdg.verify.checks import files as file_checks
from usdsdg.verify.checks.formats import (
    bop,
    coco_keypoints,
    coco_pictures,
    coco_segments,
    cosmos,
    cvat,
    dope,
    kitti,
    labeled,
    own_annotators,
    shards,
    skeletons,
    voc,
    ycb_video,
)
from usdsdg.verify.checks.formats.coco import Coco
from usdsdg.verify.checks.formats.yolo import Yolo
from usdsdg.verify.checks.tables import Tables
from usdsdg.verify.frame_numbers import check_numbers
from usdsdg.verify.integrity import Integrity
from usdsdg.verify.integrity import check as check_integrity
from usdsdg.verify.integrity.listing import JOURNAL
from usdsdg.verify.redraw import redraw
from usdsdg.verify.report import Report
from usdsdg.writers.journal.places.place import PARTS

# Of single images; those that compare images are made for each dataset.
CHECKS = (
    ids, boxes, solids, depth, camera, poses, points, arrays, bop, cosmos, dope, drawn, ycb_video, coco_keypoints,
    coco_segments, shards, labeled, voc, cvat, own_annotators, skeletons,
)  # fmt: skip
Progress = Callable[[str, int, int | None], None]
UNREAD = "no file is of a format that usdsdg reads, so only the files themselves were compared with the journal"
MISSING = "there is no record beside the files, so only what they say of each other was checked"


def verify_all(
    folder: str | os.PathLike[str],
    *,
    labels: bool = True,
    render: Sequence[int] | int | None = None,
    progress: Progress | None = None,
) -> list[Report]:
    """Check every dataset at and below `folder`, as where several writers wrote side by side; see `verify`.

    Raises:
        DatasetError: there is no such folder, or nothing in it is recognized.
    """
    check_folder(Path(folder))
    found = parts(Path(folder))
    if len(found) < 2 and not any(_is_recorded_below(folder, root) for root, _ in found):
        return [verify(folder, labels=labels, render=render, progress=progress)]
    reports = []
    for root, own in found:
        with suppress(NothingRecognized):  # such as a folder with notes
            reports.append(verify(Path(folder, root), files=own, labels=labels, render=render, progress=progress))
    if not reports:
        raise _nothing_in(folder)
    return reports


def _is_recorded_below(folder: str | os.PathLike[str], root: str | os.PathLike[str]) -> bool:
    """Return whether a dataset is below a folder, not in it, with a record of its own."""
    where = Path(folder, root)
    return where != Path(folder) and os.path.isdir(where / BESIDE)


def verify(
    folder: str | os.PathLike[str],
    *,
    files: list[str] | None = None,
    labels: bool = True,
    render: Sequence[int] | int | None = None,
    progress: Progress | None = None,
) -> Report:
    """Check the dataset in `folder`, against its journal and its record where there are any.

    files: those of the dataset; default all in the folder.
    labels: False compares the files with the journal only, by size and hash, and reads no images.
    render: numbers of frames to render again from the recorded stage, or how many, evenly spaced; this replaces the
        current stage.

    Raises:
        DatasetError: there is no such folder.
        NothingRecognized: nothing in it is recognized, or it has no journal and `labels` is False.
        BadValue: frames are to be rendered again that are not recorded, while others are.
    """
    data = Folder(Path(folder), files=files, recorded=labels)
    if render is not None and not isinstance(render, int) and data.records:
        check_numbers(str(folder), set(render), {each.number for each in data.records})
    report = Report(str(folder), recorded=len(data.records), reads_labels=labels)
    whole = attempt(report.faults, JOURNAL, "all", UNREADABLE, lambda: check_integrity(data.path, progress))
    report.add_integrity(whole)
    if not labels:
        if whole is None and report.is_clean:
            raise NothingRecognized(f"{folder} has no journal (.usdsdg), with which its files could be compared")
        return report
    _check_labels(data, report, whole, render, progress)
    return report


def _check_labels(
    data: Folder,
    report: Report,
    whole: Integrity | None,
    render: Sequence[int] | int | None,
    progress: Progress | None,
) -> None:
    """Read the images of a dataset, and check what their files say."""
    coco = Coco(data.classes)
    tables = [Tables(data.classes), coco, kitti.Kitti(), Yolo(data.classes)]
    named = _images_by_checksum(data)
    read: set[str] = set()
    samples = file_checks.Samples()
    for seen in map(Seen.complete, images(data, read)):
        report.formats[seen.format] += 1
        samples.add(seen)
        if data.records and seen.truth is None:
            report.notes.append(f"{seen.format}: image {seen.name} has no record")
        for check in (*CHECKS, *tables):
            report.faults += _found(check.check, seen)
        report.faults += _found(color.check, seen, named)
        if progress is not None:
            progress("images verified", report.formats.total(), None)
    if not report.formats and not data.records:
        if whole is None and not data.faults and report.is_clean:
            raise _nothing_in(data.path)
        report.notes.append(UNREAD if whole is not None else MISSING)
    elif not data.records:
        report.notes.append(MISSING)
    if render is not None:
        numbers, most = (None, render) if isinstance(render, int) else (render, len(render))
        again = partial(redraw, data, numbers, most=most, progress=progress)
        faults, notes, report.rendered = attempt(report.faults, STAGES, "?", UNREADABLE, again) or ([], [], 0)
        report.faults += faults
        report.notes += notes
    report.faults += data.faults
    listed = whole.listed if whole is not None else frozenset()
    is_finished = whole is None or whole.is_finished
    checks = [file_checks.check(data, read, listed=listed, is_finished=is_finished)]
    if is_finished:
        checks += [class_table.check(data), samples.check(data), coco_pictures.check(data, coco.pictures)]
    for found in checks:
        report.faults += attempt_each(report.faults, FRAMES, "?", UNREADABLE, found)
    report.faults = list(dict.fromkeys(report.faults))
    if whole is not None and any(fault.file == PARTS for fault in whole.faults):
        # Files about all frames are made when parts are joined; what a part has left of them says nothing yet.
        report.faults = [
            fault for fault in report.faults if fault.file in whole.listed or fault.file.startswith(BESIDE)
        ]


class NothingRecognized(DatasetError):
    """A folder has no dataset in a format that usdsdg writes."""


def _nothing_in(folder: str | os.PathLike[str]) -> NothingRecognized:
    return NothingRecognized(
        f"nothing in {folder} is a dataset in a format that usdsdg writes; give the folder that a writer wrote to "
        "(its output_dir)"
    )


def _found(check: Callable[..., Faults], seen: Seen, *others: Any) -> list[Fault]:
    """Return the faults that a check finds; values that it cannot make sense of are one."""
    faults: list[Fault] = []
    what = f"values are not as the format of {seen.format} has them"
    for fault in attempt_each(faults, seen.labels or seen.files[-1], seen.name, what, check(seen, *others)):
        faults.append(fault)
    return faults


def _images_by_checksum(data: Folder) -> dict[int, str]:
    """Return which frame has a color image, by its checksum."""
    named: dict[int, str] = {}
    for record in data.records:
        for product in record.products:
            if "LdrColor" in product.checksums:
                named.setdefault(product.checksums["LdrColor"], f"that of frame {record.number} of {product.name}")
    return named


__all__ = ["Fault", "Faults", "NothingRecognized", "Report", "verify", "verify_all"]
