"""Functions of scripts as members of a family: `rep.modify.register(fn)` makes `rep.modify.<fn>`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def enter(
    family: dict[str, Any], family_name: str, fn: Callable[..., Any], override: bool, fn_name: str | None
) -> None:
    """Put `fn` into the names of a family's module, under its own name or `fn_name`.

    Raises:
        ValueError: `fn` is no function, the name is no identifier, or taken while `override` is False.
    """
    if not callable(fn):
        raise ValueError(f"{family_name}.register: {fn!r} is no function")
    name = fn_name or getattr(fn, "__name__", type(fn).__name__)
    if not name.isidentifier():
        raise ValueError(f"{family_name}.register: {name!r} is not a valid name; pass fn_name='a_valid_name'")
    if name in family and not override:
        raise ValueError(f"{family_name}.register: {name!r} exists; pass override=True to replace it")
    family[name] = fn
