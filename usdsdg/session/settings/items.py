"""Parts of the settings as items: what `carb.dictionary` calls them, with keys and values, live or as a copy."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import Any, Protocol


class ItemType(IntEnum):
    """What an item is."""

    BOOL, INT, FLOAT, STRING, DICTIONARY, COUNT = range(6)


class UpdateAction(IntEnum):
    """Which value stays, where two trees that are joined have one key."""

    OVERWRITE, KEEP = range(2)


class _Store(Protocol):
    def get(self, path: str) -> Any: ...

    def set(self, path: str, value: Any) -> None: ...

    def destroy_item(self, path: str) -> None: ...


class Item:
    """What is at a path of a store: a dictionary of more, or a value."""

    def __init__(self, store: _Store, path: str) -> None:
        self._store, self.path = store, path.rstrip("/")

    def get_dict(self) -> Any:
        """Return a copy of what is here: nested dictionaries, or the value of an item that has nothing below."""
        return self._store.get(self.path)

    def get(self, key: str, default: Any = None) -> Any:
        """Return the value at a key, or at a path of keys; dictionaries as copies."""
        found = self._store.get(f"{self.path}/{key}")
        return default if found is None else found

    def get_keys(self) -> list[str]:
        """Return the keys of what is directly below."""
        found = self.get_dict()
        return list(found) if isinstance(found, Mapping) else []

    def get_key_at(self, index: int) -> str | None:
        """Return one of `get_keys`; None where there are not so many."""
        keys = self.get_keys()
        return keys[index] if 0 <= index < len(keys) else None

    def clear(self) -> None:
        """Remove all that is below."""
        for key in self.get_keys():
            self._store.destroy_item(f"{self.path}/{key}")

    def __getitem__(self, key: str) -> Any:
        return self.get(key)

    def __setitem__(self, key: str, value: Any) -> None:
        self._store.set(f"{self.path}/{key}", value)

    def __contains__(self, key: str) -> bool:
        return self.get(key) is not None

    def __len__(self) -> int:
        return len(self.get_keys())

    def __str__(self) -> str:
        return str(self.get_dict())

    def __repr__(self) -> str:
        return f"Item({self.path or '/'!r}: {self.get_dict()!r})"


def type_of(value: Any) -> ItemType:
    """Return what an item with a value is; of a list what its first value is."""
    if isinstance(value, (list, tuple)):
        return type_of(value[0]) if value else ItemType.COUNT
    kinds = ((bool, ItemType.BOOL), (int, ItemType.INT), (float, ItemType.FLOAT), (str, ItemType.STRING))
    of_value = (kind for python, kind in kinds if isinstance(value, python))
    return next(of_value, ItemType.DICTIONARY if isinstance(value, Mapping) else ItemType.COUNT)


def is_accessible(kind: ItemType, value: Any) -> bool:
    """Return whether a value can be read as one of a kind: numbers and bools as each other, all of them as text."""
    if isinstance(value, (list, tuple, Mapping)) or value is None:
        return kind is ItemType.DICTIONARY and isinstance(value, Mapping)
    if isinstance(value, str) and kind in (ItemType.INT, ItemType.FLOAT):
        try:
            float(value)
        except ValueError:
            return False
    return kind in (ItemType.BOOL, ItemType.INT, ItemType.FLOAT, ItemType.STRING)
