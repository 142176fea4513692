"""Text files about all pictures of a dataset, which grow with every one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping

from usdsdg.session.session import current
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.files import write_text

# They are rewritten after this many new pictures, or after this relative growth: for n pictures the total cost is
# proportional to n, not n².
_PICTURES, _GROWTH = 25, 0.1


class GrowingFiles(ABC):
    """Files that contain what was there at the last `write`, which is also called when the program ends."""

    def __init__(self, backend: BaseBackend) -> None:
        self._backend = backend
        self._count = 0  # pictures
        self._written = -1  # of these, those in the files
        # Also if a script ends or is interrupted before its run is complete.
        current().io_queue.call_at_exit(self.write)

    @abstractmethod
    def texts(self) -> Mapping[str, str]:
        """Return what each file is to contain, by its path; none where that is not yet known."""

    def grew(self) -> None:
        """Count a picture; write the files if they have grown enough."""
        self._count += 1
        if self._count == 1 or self._count - self._written >= max(_PICTURES, _GROWTH * self._written):
            self.write()

    def write(self) -> None:
        """Schedule the files after the pictures that they name; they are replaced atomically."""
        texts = self.texts() if self._written != self._count else {}
        if texts:
            for path, text in texts.items():
                self._backend.schedule_after_all(write_text, path=path, text=text)
            self._written = self._count
