"""Snapshots of plain data, which whoever gets them may change."""

from typing import Any

import numpy as np

_MUTABLE = (dict, list, tuple, np.ndarray)


def snapshot(value: Any) -> Any:
    """Return a copy of dictionaries, lists, tuples and NumPy arrays, also of those within; anything else as it is."""
    if type(value) is dict:
        return {key: snapshot(each) if isinstance(each, _MUTABLE) else each for key, each in value.items()}
    if type(value) in (list, tuple):
        return type(value)([snapshot(each) if isinstance(each, _MUTABLE) else each for each in value])
    return value.copy() if isinstance(value, np.ndarray) else value
