"""Keypoints of one object that have one name, of which formats have place for one."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.colors import UNLABELLED
from usdsdg.errors import warn_once


def warn_of_shared_names(writer: str, payload: Mapping[str, Any]) -> None:
    """Warn of objects with several keypoints of one name, as where several parts have them; `payload`: of `keypoints`.

    writer: whose files have one of them.
    """
    rows, names, paths = payload["data"], payload["keypointNames"], payload["primPaths"]
    owned = np.flatnonzero(rows["instanceId"] != UNLABELLED)
    pairs = np.stack([rows["instanceId"][owned], rows["keypointId"][owned]], axis=1)
    _, first, place = np.unique(pairs, axis=0, return_index=True, return_inverse=True)
    earlier = first[place.ravel()]
    again = np.flatnonzero(earlier != np.arange(len(owned)))
    if len(again):
        one, other = owned[earlier[again[0]]], owned[again[0]]
        warn_once(
            f"{writer}: {paths[one]} and {paths[other]} are parts of one object and have keypoints of one name, "
            f"{names[int(rows['keypointId'][one])]}, of which its files have the last in the picture. Name them "
            "differently."
        )
