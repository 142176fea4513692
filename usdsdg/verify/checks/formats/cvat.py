"""CVAT: labels of shapes are those of the task, and these are the classes of the dataset."""

from __future__ import annotations

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Seen
from usdsdg.writers.formats.cvat.files import ANNOTATIONS, NAME


def check(seen: Seen) -> Faults:
    """Check the labels of one picture's shapes."""
    if seen.format != NAME:
        return
    labels = seen.extra["labels"]
    for name in dict.fromkeys(each.name for each in seen.labeled):
        if name not in labels:
            yield Fault(ANNOTATIONS, seen.name, f"the task has the label {name}", "", ", ".join(labels))
    instances = [each.instance for each in seen.labeled]
    repeated = sorted({number for number in instances if number is not None and instances.count(number) > 1})
    if repeated:
        yield Fault(ANNOTATIONS, seen.name, "several shapes are of one instance", "", str(repeated))
