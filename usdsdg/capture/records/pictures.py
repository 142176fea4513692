"""What records of frames have of whole AOVs: run lengths, samples and checksums."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from usdsdg.annotators.frame import Frame
from usdsdg.record import id_runs, samples
from usdsdg.record.frame_record import OPAQUE

# Where a frame keeps them.
PICTURES = "pictures of records"
# What a record needs where labels are rendered at all.
AOVS = frozenset(("instance", "distance_to_camera"))


@dataclass(frozen=True)
class Pictures:
    """What records have of a frame's AOVs, whoever writes it; the fields are those of ProductRecord."""

    runs: tuple[np.ndarray, np.ndarray] | None
    visible: np.ndarray  # (G,) int: the gprims that the run lengths number
    depth: np.ndarray | None
    normals: np.ndarray | None
    thumbnail: np.ndarray | None
    checksums: Mapping[str, int]


_summing = threading.Lock()


def pictures_of(frame: Frame) -> Pictures:
    """Return what is recorded of a frame's AOVs; the writers that share the frame share it."""
    with _summing:
        if PICTURES not in frame.memo:
            frame.memo[PICTURES] = _summed(frame)
        return frame.memo[PICTURES]


def _summed(frame: Frame) -> Pictures:
    aovs = frame.aovs
    depth, normals, color = (aovs.get(name) for name in ("distance_to_camera", "normals", "LdrColor"))
    runs, visible = _visible_gprims(aovs.get("instance"), len(frame.gprims))
    whole = sorted(name for name in aovs if name not in AOVS | {"HdrColor", "normals"})
    checksums = {name: samples.checksum(aovs[name]) for name in whole}
    if depth is not None:
        checksums["distance_to_camera"] = samples.checksum(depth)
    if color is not None and not samples.is_opaque(color):
        checksums[OPAQUE] = samples.checksum(color[..., :3])
    if normals is not None:
        checksums["normal_image"] = samples.checksum(samples.normal_image(normals))
    return Pictures(
        runs,
        visible,
        None if depth is None else samples.grid(depth),
        None if normals is None else samples.normal_steps(samples.grid(normals)),
        None if color is None else samples.block_means(color),
        checksums,
    )


def _visible_gprims(instance: np.ndarray | None, count: int) -> tuple[tuple[np.ndarray, np.ndarray] | None, np.ndarray]:
    """Return the run lengths of the image of visible gprims, numbered without gaps, and the gprim of each number."""
    if instance is None:
        return None, np.zeros(0, np.int64)
    values, lengths = id_runs.encode(instance)
    seen = np.zeros(count, bool)
    seen[values[values >= 0]] = True
    number = np.append(np.cumsum(seen) - 1, -1)
    return (id_runs.narrow(number[values.astype(np.int64)]), lengths), np.flatnonzero(seen)
