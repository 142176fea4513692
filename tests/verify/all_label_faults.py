"""The kinds of label faults of all formats."""

from tests.verify import label_faults_annotations  # noqa: F401 - adds its kinds
from tests.verify.label_faults import KINDS, Kind

__all__ = ["KINDS", "Kind"]
