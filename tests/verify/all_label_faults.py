"""The kinds of label faults of all formats."""

from tests.verify import (  # noqa: F401 - they add their kinds
    label_faults_coco,
    label_faults_cvat,
    label_faults_kitti,
    label_faults_shards,
    label_faults_voc,
)
from tests.verify.label_faults import KINDS, Kind

__all__ = ["KINDS", "Kind"]
