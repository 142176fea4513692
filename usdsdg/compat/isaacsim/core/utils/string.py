"""`isaacsim.core.utils.string`: free names."""

from __future__ import annotations

from collections.abc import Callable


def find_unique_string_name(initial_name: str, is_unique_fn: Callable[[str], bool]) -> str:
    """Return the name, or with the first number "_1", "_2", ... for which `is_unique_fn(name)` holds."""
    name, number = initial_name, 0
    while not is_unique_fn(name):
        number += 1
        name = f"{initial_name}_{number}"
    return name


def find_root_prim_path_from_regex(prim_path_regex: str) -> tuple[str, int]:
    """Return the part of a pattern before the first part with a regular expression, and that part's number."""
    parts = prim_path_regex.split("/")
    for number, part in enumerate(parts):
        if "*" in part:
            return "/".join(parts[:number]), number
    return prim_path_regex, len(parts) - 1
