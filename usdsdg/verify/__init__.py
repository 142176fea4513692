"""Proof of a dataset: its files are read back through their format, and compared with the record and geometry."""

from usdsdg.datasets.faults import Fault
from usdsdg.verify.report import Report
from usdsdg.verify.verify import NothingRecognized, verify, verify_all

__all__ = ["Fault", "NothingRecognized", "Report", "verify", "verify_all"]
