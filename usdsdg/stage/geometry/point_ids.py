"""The numbers by which annotators name the points of a point instancer: its ids, where they tell points apart."""

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.errors import warn_once


def point_numbers(instancer: UsdGeom.PointInstancer, count: int, time: Usd.TimeCode) -> list[int]:
    """Return a number for each of `count` points: their ids, or their indices where there is not one id for each.

    Ids of which two are equal count as none, with a warning: else two objects would have one label.
    """
    authored = instancer.GetIdsAttr().Get(time)
    ids = np.asarray(() if authored is None else authored)
    if ids.shape != (count,) or ids.dtype.kind not in "iu":  # files may declare another type
        if ids.size:
            warn_once(
                f"{instancer.GetPath()}: its ids are not one whole number for each of its {count} points, so "
                "annotators number these by their indices. Author one id a point, or none."
            )
        return list(range(count))
    if len(np.unique(ids)) < count:
        warn_once(
            f"{instancer.GetPath()}: some of its ids are equal, so annotators number its points by their indices. Give "
            f"each point an id of its own, or author no ids."
        )
        return list(range(count))
    return ids.tolist()
