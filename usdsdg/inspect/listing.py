"""Reading of the files of a dataset that reports broken files as problems."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from usdsdg.inspect.records import Dataset, Problem

UNREADABLE = "unreadable file"


def read_json(dataset: Dataset, path: Path, frame: str | None = None) -> Any | None:
    """Return the values of a JSON file of the dataset; None if it is broken, which is added to the problems."""
    try:
        return json.loads((dataset.folder / path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        dataset.problems.append(Problem(UNREADABLE, f"{path}: {_short(error)}", frame))
        return None


def read_array(dataset: Dataset, path: Path, frame: str | None = None) -> np.ndarray | None:
    """Return the array of a .npy file of the dataset; None if it is broken, which is added to the problems."""
    try:
        return np.load(dataset.folder / path, allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        dataset.problems.append(Problem(UNREADABLE, f"{path}: {_short(error)}", frame))
        return None


def _short(error: Exception) -> str:
    if isinstance(error, json.JSONDecodeError):
        return f"not valid JSON at line {error.lineno}: {error.msg}"
    return str(error).splitlines()[0] if str(error) else type(error).__name__
