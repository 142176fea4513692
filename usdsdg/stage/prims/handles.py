"""What a reader of changes knows properties by."""

from collections.abc import Iterable
from typing import Any

from pxr import Sdf


class Handles:
    """Property paths -> what their reader knows them by, such as the row of a table; None is no handle.

    Attributes:
        version: another number after each change of the contents.
    """

    def __init__(self) -> None:
        self._known: dict[Sdf.Path, Any] = {}
        self.get = self._known.get
        self.version = 0

    def __bool__(self) -> bool:
        return bool(self._known)

    def note(self, paths: Iterable[Sdf.Path], handle: Any) -> None:
        """Report these properties as `handle` from now on."""
        for path in paths:
            if path not in self._known or self._known[path] is not handle:
                self._known[path] = handle
                self.version += 1

    def drop(self, paths: Iterable[Sdf.Path]) -> None:
        """Report these properties by their names again."""
        for path in paths:
            if self._known.pop(path, None) is not None:
                self.version += 1

    def forget(self) -> None:
        """Report all properties by their names again."""
        self._known.clear()
        self.version += 1
