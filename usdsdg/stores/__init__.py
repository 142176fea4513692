"""Stores of files by relative path: a local folder, a bucket of S3, Google or Azure, a web server, memory.

    store = open_store("s3://bucket/runs/7")      # or "gs://", "az://", "https://", "file://", a folder
    store.put("notes.txt", b"...")

Every member has the same few operations, conditional puts among them, so that locks and journals need no writer.
"""

from usdsdg.stores.opening import open_store
from usdsdg.stores.store import Entry, Store

__all__ = ["Entry", "Store", "open_store"]
