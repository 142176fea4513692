"""`isaacsim.benchmark.services.datarecorders.stats_utils`: mean, spread and extremes of samples."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass
class Stats:
    """Statistics of samples, rounded to two places; `stdev` is that of a sample (n - 1)."""

    mean: float
    median: float
    stdev: float
    min: float
    max: float
    p99: float

    @classmethod
    def from_samples(cls, samples: Sequence[float], trim_outliers: bool = True) -> Stats:
        """Return the statistics; without the lowest and highest tenth of 100 samples or more if `trim_outliers`."""
        if not samples:
            return cls(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        kept = sorted(samples)
        if trim_outliers and len(kept) >= 100:
            tenth = len(kept) // 10
            kept = kept[tenth:-tenth]
        found = (
            statistics.mean(kept), statistics.median(kept), statistics.stdev(kept) if len(kept) > 1 else 0.0,
            kept[0], kept[-1], float(np.percentile(kept, 99.0)),
        )  # fmt: skip
        return cls(*(round(value, 2) for value in found))

    def to_dict(self) -> dict[str, float]:
        """Return the statistics by name; the 99th percentile is "one_percent"."""
        return {
            "mean": self.mean, "median": self.median, "stdev": self.stdev, "min": self.min, "max": self.max,
            "one_percent": self.p99,
        }  # fmt: skip
