"""Pictures, arrays and values to files: the functions that writers use, and `backend.schedule` takes.

Without a backend (or with a backend's class) a path is that of a file on this machine.
"""

from __future__ import annotations

from usdsdg.writers.files import (
    read_exr,
    write_exr,
    write_image,
    write_jpeg,
    write_json,
    write_np,
    write_pickle,
    write_png,
)

__all__ = [
    "read_exr", "write_exr", "write_image", "write_jpeg", "write_json", "write_np", "write_pickle", "write_png",
]  # fmt: skip
