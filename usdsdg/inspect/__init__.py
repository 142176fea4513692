"""One self-contained HTML page about a dataset: images with their labels drawn, counts, histograms, problems."""

from usdsdg.inspect.report import inspect

__all__ = ["inspect"]
