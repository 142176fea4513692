"""Integrity of a dataset: its files, by size and hash, as its journal lists them; nothing is read as an image."""

from usdsdg.verify.integrity.integrity import Integrity, check

__all__ = ["Integrity", "check"]
