"""Files about all frames, made again of the records that are whole beside the data."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from usdsdg.errors import UsdsdgError, described
from usdsdg.session.session import current
from usdsdg.stores.paths import path_below
from usdsdg.writers.aggregates import write_spool
from usdsdg.writers.backends.disk import DiskBackend
from usdsdg.writers.journal.run import Run


class _OfDataset(DiskBackend):
    """Writes to a scratch folder, and reads the pictures of the dataset, of which videos are made."""

    ends_run = True

    def __init__(self, scratch: Path, folder: Path) -> None:
        super().__init__(scratch)
        self._dataset = folder

    def read_blob(self, path: str) -> bytes:
        return path_below(self._dataset, path).read_bytes()


def write(folder: Path, spools: Iterable[Path], to: Path) -> str:
    """Write the files of spools of a dataset below a scratch folder; return why some cannot be made, or "".

    folder: of the dataset, absolute. This ends the run of the process.
    """
    current().run = Run()
    backend = _OfDataset(to, folder)
    why = ""
    for spool in sorted(set(spools)):
        try:
            write_spool(spool, backend)
        except (UsdsdgError, OSError) as error:  # such as of pictures of a video, which are not there
            why = described(error) if isinstance(error, UsdsdgError) else f"{error.filename or spool}: {error.strerror}"
    return why
