"""The folder of temporary files, or an error that says how to name one."""

from __future__ import annotations

import tempfile

from usdsdg.errors import OutputNotWritable


def temporary_root() -> str:
    """Return the folder in which temporary files are made.

    Raises:
        OutputNotWritable: none can be written to, as where the disk of the system is full, or all but the output
            folder is read-only.
    """
    try:
        return tempfile.gettempdir()
    except FileNotFoundError as error:
        raise OutputNotWritable(
            f"Temporary files are needed, and no folder for them can be written to: {error.strerror}. Free space "
            "there, or name another: export TMPDIR=FOLDER."
        ) from None
