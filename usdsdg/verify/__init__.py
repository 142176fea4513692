"""Proof of a dataset: its files are read back through their format, and compared with the record and geometry."""

from usdsdg.verify.faults import Fault, Report
from usdsdg.verify.verify import verify

__all__ = ["Fault", "Report", "verify"]
