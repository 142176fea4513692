"""Files about all frames that grow with them, such as the names of the classes, where several processes make frames."""

from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.journal.run import get_run
from usdsdg.writers.spool import place_of


def keep_latest(backend: BaseBackend, path: str, text: str) -> None:
    """Tell the text that a writer gives such a file at this frame, beside scheduling it.

    Processes of parts write the same file, in whatever order they come; those who join the parts write the longest
    text, which the one with the last picture has told.
    """
    place = place_of(backend)
    claimed = get_run().claim(place) if place is not None else None
    if claimed is not None:
        claimed.keep_latest(path, text.encode())
