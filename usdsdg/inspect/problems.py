"""What looks wrong in a dataset without a look at its pixels: broken files, files that are missing, gaps."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from pathlib import PurePosixPath

from usdsdg.datasets.faults import Fault
from usdsdg.datasets.folder import Folder
from usdsdg.errors import counted
from usdsdg.inspect.records import Dataset, Frame, Problem

UNREADABLE = "unreadable file"
_MISSING = "missing file"
# A file per object has a second number; how many there are differs from frame to frame.
_PER_OBJECT = re.compile(r"#_\d")
_NUMBER = re.compile(r"\d+$")


def add_faults(dataset: Dataset, part: str, folder: Folder) -> None:
    """Add what could not be read in a folder."""
    names = {frame.seen.name: frame.name for frame in dataset.frames if frame.folder is folder}
    for fault in folder.faults:
        dataset.problem(Problem(_kind(fault), _text(part, fault), names.get(fault.frame)))


def _kind(fault: Fault) -> str:
    if fault.what == "is missing":
        return _MISSING
    return UNREADABLE if fault.what.startswith(("cannot be read", "is not")) else "odd labels"


def _text(part: str, fault: Fault) -> str:
    compared = f": expected {fault.expected}, found {fault.found}" if fault.expected or fault.found else ""
    return f"{f'{part}/' if part else ''}{fault.file}: {fault.what.removeprefix('cannot be read: ')}{compared}"


def check_pairs(dataset: Dataset) -> None:
    """Check that pictures have labels, labels pictures, and frames objects."""
    for frames in _groups(dataset).values():
        labels, pictures = (any(getattr(each.seen, name) for each in frames) for name in ("labels", "picture"))
        for frame in frames:
            seen = frame.seen
            if seen.labels and not seen.picture and (pictures or not seen.steps):
                text = f"{frame.path(seen.labels)}: there is no picture of it"
                dataset.problem(Problem("labels without picture", text, frame.name))
            elif frame.labeled and not frame.objects:
                dataset.problem(Problem("empty frame", f"{frame.name}: no object in view", frame.name))
            if not seen.labels and labels:
                text = f"{frame.path(seen.picture or seen.files[0])}: there are no labels of it"
                dataset.problem(Problem("picture without labels", text, frame.name))


def check_complete(dataset: Dataset) -> None:
    """Check that every frame of a view has the files that most frames of that view have."""
    for frames in _groups(dataset).values():
        patterns = [{_pattern(file, frame): file for file in frame.seen.files} for frame in frames]
        counts = Counter(pattern for each in patterns for pattern in each)
        usual = {pattern for pattern, count in counts.items() if 2 * count > len(frames)}
        told = {_pattern(getattr(frame.seen, name), frame) for frame in frames for name in ("picture", "labels")}
        for frame, own in zip(frames, patterns):
            is_told = not frame.seen.picture or not frame.seen.labels
            for pattern in sorted(usual - own.keys()):
                if _PER_OBJECT.search(pattern) or (is_told and pattern in told):
                    continue
                file = frame.path(pattern.replace("#", _number(frame)))
                dataset.problem(Problem(_MISSING, f"{file}: is missing", frame.name))


def check_numbers(dataset: Dataset) -> None:
    """Check that the numbers of frames have no gaps; parts of a dataset, such as train and val, share them."""
    by_view: dict[tuple[str, str], set[int]] = defaultdict(set)
    for frame in dataset.frames:
        number = _number(frame)
        if number and not re.fullmatch(r"\d+(?:_\d+)+", frame.seen.frame):
            by_view[frame.view, frame.seen.format].add(int(number))
    for (view, _), numbers in sorted(by_view.items()):
        missing = sorted(set(range(min(numbers), max(numbers) + 1)) - numbers)
        if missing:
            where = f"{view}: " if view else ""
            listed = ", ".join(str(number) for number in missing[:20]) + (" …" if len(missing) > 20 else "")
            count = counted(len(missing), "frame number", "frame numbers")
            have = "has" if len(missing) == 1 else "have"
            text = f"{where}{count} between the first and the last {have} no files: {listed}"
            dataset.problem(Problem("gap in the numbers", text))


def _groups(dataset: Dataset) -> dict[tuple[str, ...], list[Frame]]:
    """Return the frames that should have the same files: those of a view and a part such as train."""
    groups: dict[tuple[str, ...], list[Frame]] = defaultdict(list)
    for frame in dataset.frames:
        split = PurePosixPath(frame.seen.frame).parent.as_posix()
        groups[frame.part, frame.seen.format, frame.seen.view, split].append(frame)
    return groups


def _number(frame: Frame) -> str:
    """Return the digits at the end of a frame's name; "" for none."""
    match = _NUMBER.search(frame.seen.frame)
    return match[0] if match else ""


def _pattern(file: str, frame: Frame) -> str:
    """Return the name of a file with # for the frame's number."""
    path, number = PurePosixPath(file), _number(frame)
    return str(path.with_name(path.name.replace(number, "#"))) if file and number else file
