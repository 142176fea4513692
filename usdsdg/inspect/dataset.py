"""Reading of a dataset folder: which writers made it, what they wrote, what looks wrong."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path, PurePosixPath

from usdsdg.datasets.folder import Folder, check_folder
from usdsdg.datasets.parts import parts
from usdsdg.datasets.reading import images, objects_of
from usdsdg.datasets.seen import Seen
from usdsdg.errors import DatasetError
from usdsdg.inspect import problems
from usdsdg.inspect.records import Dataset, Frame
from usdsdg.writers.base import METADATA

DOPE_NOTE = (
    "The files of this format tell no usable distance: `location` follows Replicator's order of matrices, so it does "
    "not project to the objects."
)


def read_dataset(path: Path) -> Dataset:
    """Read the labels of all datasets at and below a folder; pixels are read when the images are drawn.

    Raises:
        DatasetError: the folder is missing, or nothing in it is recognized; lists what was looked for.
    """
    check_folder(path)
    dataset, found = Dataset(path), parts(path)
    folders = {part: Folder(path / part, files=files, recorded=False) for part, files in found}
    for part, folder in folders.items():
        _read_part(dataset, part, folder)
    if not dataset.frames:
        raise DatasetError(_nothing_found(path, list(folders.values())))
    _check_distances(dataset)
    problems.check_pairs(dataset)
    problems.check_complete(dataset)
    problems.check_numbers(dataset)
    return dataset


def _read_part(dataset: Dataset, part: str, folder: Folder) -> None:
    writers: Counter[str] = Counter()
    for seen in images(folder, set()):
        writers[f"{seen.format}, {seen.variant} format" if seen.variant else seen.format] += 1
        dataset.unshown = dict(Counter(dataset.unshown) + Counter(seen.undrawn))
        if seen.undrawn and not (seen.picture or seen.labels) and len(seen.undrawn) == len(seen.files):
            continue
        frame = Frame(part, folder, seen)
        dataset.frames.append(frame)
        _read_objects(frame)
        for note in seen.notes:
            dataset.note(note)
    dataset.writers += [name for name in sorted(writers) if name not in dataset.writers]
    _read_metadata(dataset, folder)
    problems.add_faults(dataset, part, folder)


def _read_objects(frame: Frame) -> None:
    seen, folder = frame.seen, frame.folder
    parsed = folder.parsed(seen.labels or seen.picture, seen.name, lambda: objects_of(seen))
    frame.objects = parsed or []
    broken = any(fault.frame == seen.name for fault in folder.faults)
    frame.labeled = bool(seen.labels) and (bool(frame.objects) or not broken)


def _nothing_found(path: Path, folders: list[Folder]) -> str:
    if faults := [fault for folder in folders for fault in folder.faults]:
        return f"nothing in {path} can be shown: {faults[0].line()}"
    endings = Counter(each.suffix or each.name for folder in folders for each in map(PurePosixPath, folder.files))
    if not endings:
        return f"{path} is empty; give the folder that a writer wrote to (its output_dir)"
    found = ", ".join(f"{count} x {ending}" for ending, count in endings.most_common(5))
    return (
        f"nothing in {path} is a dataset that can be shown: no file is named as a writer names them, such as "
        f"rgb_0000.png of BasicWriter, only {found}. Give the folder that a writer wrote to (its output_dir)"
    )


def _read_metadata(dataset: Dataset, folder: Folder) -> None:
    """Keep the content of the first metadata.txt: writer, version and seed."""
    name = next((each for each in folder.files if PurePosixPath(each).name == METADATA), None)
    if name is None or dataset.metadata:
        return
    # NaN is not valid JSON, so it must not reach the page.
    values = folder.binary(name, "all", lambda data: json.loads(data, parse_constant=lambda constant: None))
    dataset.metadata = values if isinstance(values, dict) else {}


def _check_distances(dataset: Dataset) -> None:
    """Discard distances of DOPE's format if only a few locations match, which is by chance, and add a note."""
    objects = [each for frame in dataset.frames if _is_dope(frame.seen) for each in frame.objects]
    known = [each for each in objects if each.distance is not None]
    if not objects or len(known) > 0.8 * len(objects):
        return
    dataset.note(DOPE_NOTE)
    for each in known:
        each.distance = None


def _is_dope(seen: Seen) -> bool:
    return any(poses.format == "dope" for poses in seen.poses)
