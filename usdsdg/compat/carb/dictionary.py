"""`carb.dictionary`: items of the settings, and what is read of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from usdsdg.compat.wrappers.unsupported import RefusedNames, refused_function
from usdsdg.session.settings.items import Item, ItemType, UpdateAction, is_accessible, type_of

__all__ = [
    "IDictionary", "Item", "ItemType", "UpdateAction", "acquire_dictionary_interface", "get_dictionary",
    "get_dictionary_interface", "get_json_serializer", "get_toml_serializer",
]  # fmt: skip

_WHY = (
    "items are those of the settings: carb.settings.get_settings() sets and removes them, and dictionaries of Python "
    "hold what is no setting"
)
_FILES = "json and tomllib of Python read and write files, and carb.settings.get_settings().set takes dictionaries"


def _value(item: Item | Any, path: str = "") -> Any:
    """Return what is at a path of an item; listeners of one setting get its value in place of an item."""
    if not isinstance(item, Item):
        return item
    return item.get(path) if path.strip("/") else item.get_dict()


class IDictionary:
    """Reads items; what creates and changes items of their own raises `Unsupported`."""

    __getattr__ = RefusedNames(
        "carb.dictionary.IDictionary", ("create_item", "set", "update", "readLock", "writeLock", "unlock", "get_"), _WHY
    )

    def get(self, base_item: Item, path: str = "") -> Any:
        """Return the value at a path of an item, dictionaries as copies."""
        return _value(base_item, path)

    get_dict_copy = get

    def get_item(self, base_item: Item, path: str = "") -> Item | None:
        """Return the item at a path of an item; None where there is nothing."""
        if not path.strip("/"):
            return base_item
        return Item(base_item._store, f"{base_item.path}/{path.strip('/')}") if path in base_item else None

    def get_item_name(self, base_item: Item, path: str = "") -> str:
        """Return the key of an item."""
        return f"{base_item.path}/{path}".rstrip("/").rpartition("/")[2]

    def get_item_child_count(self, item: Item) -> int:
        """Return how many items are directly below."""
        return len(item)

    def get_item_type(self, item: Item) -> ItemType:
        """Return what an item is."""
        return type_of(_value(item))

    def get_array_length(self, item: Item) -> int:
        """Return how many values a list has; 0 for what is none."""
        value = _value(item)
        return len(value) if isinstance(value, (list, tuple)) else 0

    def get_as_bool(self, item: Item) -> bool:
        """Return the value as a bool; False for a dictionary."""
        return not isinstance(_value(item), Mapping) and bool(_value(item))

    def get_as_int(self, item: Item) -> int:
        """Return the value as an integer."""
        return int(_value(item) or 0)

    def get_as_float(self, item: Item) -> float:
        """Return the value as a float."""
        return float(_value(item) or 0.0)

    def get_as_string(self, base_item: Item, path: str = "") -> str:
        """Return the value at a path of an item as a string."""
        value = _value(base_item, path)
        return "" if value is None else str(value)

    def is_accessible_as(self, item_type: ItemType, item: Item) -> bool:
        """Return whether the value of an item can be read as one of a type."""
        return is_accessible(item_type, _value(item))

    def destroy_item(self, item: Item) -> None:
        """Let go of a copy, which Python does by itself."""


_dictionary = IDictionary()


def get_dictionary() -> IDictionary:
    """Return what reads items."""
    return _dictionary


acquire_dictionary_interface = get_dictionary_interface = get_dictionary
get_json_serializer = refused_function("carb.dictionary.get_json_serializer", _FILES)
get_toml_serializer = refused_function("carb.dictionary.get_toml_serializer", _FILES)
