"""Reading of a dataset folder: which writers made it, what they wrote, what looks wrong."""

import json
from collections import Counter
from pathlib import Path

from usdsdg.datasets.listing import files_below
from usdsdg.errors import DatasetError
from usdsdg.inspect import read_basic, read_pose
from usdsdg.inspect.records import Dataset, Problem


def read_dataset(folder: Path) -> Dataset:
    """Read everything that PoseWriter and BasicWriter wrote below a folder.

    Raises:
        DatasetError: the folder is missing, or nothing in it is recognized; lists what was looked for.
    """
    if not folder.is_dir():
        what = "is a file" if folder.exists() else "does not exist"
        raise DatasetError(f"{folder} {what}; give the folder that a writer wrote to (its output_dir)")
    files = list(files_below(folder))
    dataset = Dataset(folder)
    rest = sorted(set(files) - set(read_basic.read(dataset, files)))
    read_pose.read(dataset, rest)
    if not dataset.frames:
        raise DatasetError(_nothing_found(folder, files))
    dataset.metadata = _metadata(dataset, files)
    _check_frames(dataset)
    return dataset


def _nothing_found(folder: Path, files: list[Path]) -> str:
    endings = Counter(path.suffix or path.name for path in files)
    seen = ", ".join(f"{count} x {ending}" for ending, count in endings.most_common(5)) or "no files at all"
    return (
        f"nothing in {folder} is a dataset that can be shown. Looked for {read_pose.LOOKED_FOR}, and for "
        f"{read_basic.LOOKED_FOR}, up to six folders deep; found {seen}. Of other writers no page can be made"
    )


def _metadata(dataset: Dataset, files: list[Path]) -> dict:
    """Return the content of metadata.txt: writer, version and seed."""
    for path in files:
        if path.name == "metadata.txt":
            try:
                text = (dataset.folder / path).read_text(encoding="utf-8")
                # NaN is not valid JSON, so it must not reach the page.
                values = json.loads(text, parse_constant=lambda constant: None)
            except (OSError, ValueError):
                dataset.problems.append(Problem("unreadable file", f"{path}: not valid JSON"))
                continue
            return values if isinstance(values, dict) else {}
    return {}


def _check_frames(dataset: Dataset) -> None:
    by_view: dict[str, list[int]] = {}
    for frame in dataset.frames:
        if frame.labeled and not frame.objects:
            dataset.problems.append(Problem("empty frame", f"{frame.name}: no object in view", frame.name))
        if frame.number.isdigit():
            by_view.setdefault(frame.view, []).append(int(frame.number))
    for view, numbers in sorted(by_view.items()):
        missing = sorted(set(range(min(numbers), max(numbers) + 1)) - set(numbers))
        if missing:
            where = f"{view}: " if view else ""
            listed = ", ".join(str(number) for number in missing[:20]) + (" …" if len(missing) > 20 else "")
            text = f"{where}{len(missing)} frame numbers between the first and the last have no files: {listed}"
            dataset.problems.append(Problem("gap in the numbers", text))
