"""What tools say while they read: messages of loggers, and Python's warnings."""

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager


class Heard(logging.Handler):
    """What is logged as a warning."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.texts: list = []

    def emit(self, record: logging.LogRecord) -> None:
        self.texts.append(record.getMessage())


@contextmanager
def listening(logger: logging.Logger | None = None) -> Iterator[list]:
    """Give a list that has the warnings after the block: those of a logger, default all, and Python's."""
    heard, logger = Heard(), logger or logging.getLogger()
    logger.addHandler(heard)
    try:
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            yield heard.texts
    finally:
        logger.removeHandler(heard)
        # How a tool uses other packages is not of the files.
        heard.texts += [str(each.message) for each in said if not issubclass(each.category, DeprecationWarning)]


def row(texts: list, tool: str) -> list:
    """Return the row about the warnings of a tool."""
    return [f"warnings of {tool}", "; ".join(sorted(set(texts)))[:300] or "none", not texts]
