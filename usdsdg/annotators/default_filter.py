"""The label filter of a writer that was given none."""

from typing import Self

from usdsdg.session.session import current

CLASSES = "class:*"


class DefaultFilter(str):
    """The filter "class:*", until a script sets the session's.

    A writer of Replicator sets the session's filter when it is initialized, so that one that a script sets afterward
    takes its place, and one that it set before does not.
    """

    _sets: int

    def __new__(cls, text: str = CLASSES) -> Self:
        made = super().__new__(cls, text)
        made._sets = current().label_filter_sets
        return made

    def in_force(self) -> str | None:
        """Return the filter that applies now; None lets every label pass."""
        return current().label_filter if current().label_filter_sets > self._sets else str(self)
