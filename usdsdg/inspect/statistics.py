"""Counts and histograms over all objects of a dataset, by class."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from usdsdg.datasets.seen_object import SeenObject
from usdsdg.inspect.records import Dataset, Frame

BINS = 24

# Distinguishable also with most color vision deficiencies; reused cyclically for more classes.
COLORS = (
    "#3b82f6", "#f59e0b", "#10b981", "#ef4444", "#a855f7", "#06b6d4", "#ec4899", "#84cc16", "#f97316", "#6366f1",
    "#14b8a6", "#eab308", "#d946ef", "#22c55e", "#0ea5e9", "#f43f5e",
)  # fmt: skip


def classes(dataset: Dataset) -> list[dict[str, Any]]:
    """Return name, color, and number of objects and images per class, the most frequent first."""
    objects: dict[str, int] = {}
    pictures: dict[str, int] = {}
    for frame in dataset.frames:
        for seen in frame.objects:
            objects[seen.label] = objects.get(seen.label, 0) + 1
        for label in {seen.label for seen in frame.objects}:
            pictures[label] = pictures.get(label, 0) + 1
    names = sorted(objects, key=lambda name: (-objects[name], name))
    return [
        {"name": name, "color": COLORS[i % len(COLORS)], "objects": objects[name], "frames": pictures[name]}
        for i, name in enumerate(names)
    ]


def histograms(dataset: Dataset, names: Sequence[str]) -> list[dict[str, Any]]:
    """Return a histogram per property that any object has: title, unit, bin edges, and counts per class."""
    properties: list[tuple[str, str, str, Callable[[SeenObject], float | None]]] = [
        ("size", "Object size", "px, side of a square of the same area", lambda seen: seen.size),
        ("distance", "Distance", "m from the camera", lambda seen: seen.distance),
        ("visibility", "Visibility", "fraction that is not occluded", lambda seen: seen.visibility),
        ("truncation", "Truncation", "fraction outside the image", lambda seen: seen.truncation),
    ]
    made = [_histogram(dataset, names, *each) for each in properties]
    return [histogram for histogram in [*made, _per_picture(dataset)] if histogram is not None]


def _histogram(
    dataset: Dataset, names: Sequence[str], key: str, title: str, unit: str, read: Callable[[SeenObject], float | None]
) -> dict[str, Any] | None:
    values: dict[str, list[float]] = {name: [] for name in names}
    for frame in dataset.frames:
        for seen in frame.objects:
            value = read(seen)
            if value is not None and np.isfinite(value):
                values[seen.label].append(value)
    everything = np.concatenate([np.array(each, float) for each in values.values()]) if values else np.array([])
    if not len(everything):
        return None
    edges = np.linspace(0.0, 1.0, 21) if key in ("visibility", "truncation") else nice_edges(float(everything.max()))
    # Rounding leaves some fractions slightly outside 0…1.
    counts = {
        name: np.histogram(np.clip(each, edges[0], edges[-1]), edges)[0].tolist() for name, each in values.items()
    }
    return {
        "key": key,
        "title": title,
        "unit": unit,
        "edges": [float(f"{edge:.6g}") for edge in edges],
        "counts": counts,
        "median": float(f"{np.median(everything):.4g}"),
        "objects": len(everything),
    }


def _per_picture(dataset: Dataset) -> dict[str, Any] | None:
    """Return the histogram of objects per image, not by class."""
    counts = [len(frame.objects) for frame in dataset.frames if _counted(frame)]
    if not counts:
        return None
    most = max(counts)
    step = max(1, -(-(most + 1) // BINS))
    edges = np.arange(0, most + step + 1, step)
    return {
        "key": "objects",
        "title": "Objects per picture",
        "unit": "objects",
        "edges": edges.tolist(),
        "counts": {"": np.histogram(counts, edges)[0].tolist()},
        "median": float(np.median(counts)),
        "objects": len(counts),
    }


def _counted(frame: Frame) -> bool:
    return frame.labeled


def nice_edges(highest: float) -> np.ndarray:
    """Return edges from 0 to at least `highest` in about BINS steps of 1, 2, 2.5 or 5 times a power of ten."""
    rough = max(highest, 1e-6) / BINS
    power = 10.0 ** np.floor(np.log10(rough))
    step = next(factor * power for factor in (1.0, 2.0, 2.5, 5.0, 10.0) if factor * power >= rough * 0.999999)
    return np.arange(0.0, highest + step, step)
