"""The kinds of label faults of all formats."""

from tests.verify import label_faults_annotations, label_faults_shards  # noqa: F401 - they add their kinds
from tests.verify.label_faults import KINDS, Kind

__all__ = ["KINDS", "Kind"]
