"""One self-contained HTML page over a dataset: pictures with their labels drawn in, counts, histograms, problems."""

from usdsdg.inspect.report import inspect

__all__ = ["inspect"]
