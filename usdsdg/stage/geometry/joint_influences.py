"""Faults of how joints hold the points of a mesh, which UsdSkel skins without a word."""

from __future__ import annotations

import numpy as np
from pxr import Usd, UsdSkel

from usdsdg.errors import warn_once

# Weights in half floats or bytes sum to one within this.
MOST_OFF_ONE = 0.02


def warn_of_influences(prim: Usd.Prim, mesh: UsdSkel.SkinningQuery, joints: int, time: Usd.TimeCode) -> None:
    """Warn of indices that are no joints, and of weights that no points can have.

    joints: how many the mesh can name: those of its skel:joints, else those of the skeleton.
    """
    influences = mesh.ComputeJointInfluences(time)
    if influences is None:
        return
    indices, weights = (np.array(each) for each in influences)
    if not len(indices) or len(indices) != len(weights):
        return
    foreign = indices[(indices < 0) | (indices >= joints)]
    if len(foreign):
        warn_once(
            f"{prim.GetPath()}: jointIndices has {foreign[0]}, and there are {joints} joints, counted from 0. Correct "
            "it, or skel:joints."
        )
    wrong = weights[~(np.isfinite(weights) & (weights >= 0.0))]
    if len(wrong):
        warn_once(
            f"{prim.GetPath()}: jointWeights has {wrong[0]:g}; points with such a weight are drawn where it puts them. "
            "Author weights from 0 to 1."
        )
    per_point = weights.reshape(-1, mesh.GetNumInfluencesPerComponent())
    if len(held_by_none := np.flatnonzero((per_point == 0.0).all(axis=1))):
        warn_once(
            f"{prim.GetPath()}: jointWeights has only 0 for {len(held_by_none)} of {len(per_point)} points, the first "
            f"of them point {held_by_none[0]}, which no joint holds: they are drawn at the origin of the skeleton. "
            "Give each a weight."
        )
    sums = per_point.sum(axis=1, dtype=np.float64)
    if len(off := np.flatnonzero((np.abs(sums - 1.0) > MOST_OFF_ONE) & (sums > 0.0))):
        warn_once(
            f"{prim.GetPath()}: the jointWeights of {len(off)} of {len(per_point)} points do not sum to 1, those of "
            f"point {off[0]} to {sums[off[0]]:.3g}: they are drawn nearer to the origin of the skeleton, or farther "
            "from it. Normalize the weights."
        )
