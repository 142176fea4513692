"""Registry of named members (annotators, writers, ...), and registration of script functions in a module."""

import difflib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, Generic, TypeVar

from usdsdg.errors import UsdsdgError

Member = TypeVar("Member")


class Registry(Generic[Member]):
    """A mapping from names to the members of one family, in insertion order."""

    def __init__(
        self, family: str, error: type[UsdsdgError], *, likely: Mapping[str, Sequence[str]] | None = None
    ) -> None:
        """Args:
        family: what a member is called in messages, in the singular ("writer").
        error: raised for names that are unknown or taken.
        likely: by words in lower case that a name may have, members that are meant, which no spelling is near to.
        """
        self._likely = likely or {}
        self.family = family
        self._error = error
        self._members: dict[str, Member] = {}

    def add(self, name: str, member: Member, *, override: bool = True) -> None:
        """Register `member` under `name`.

        Raises:
            the registry's error: `name` is taken and `override` is False.
        """
        if not override and name in self._members:
            article = "An" if self.family[0] in "aeiou" else "A"
            raise self._error(
                f"{article} {self.family} named {name!r} exists already. Choose another name or unregister it."
            )
        self._members[name] = member

    def get(self, name: str) -> Member:
        """Return the member called `name`.

        Raises:
            the registry's error: there is none; the message lists near misses, or all names.
        """
        try:
            return self._members[name]
        except KeyError:
            raise self._error(self._unknown(name)) from None

    def remove(self, name: str) -> Member:
        """Unregister `name` and return its member; raises as `get` does."""
        member = self.get(name)
        del self._members[name]
        return member

    def names(self) -> list[str]:
        """Return all names, in insertion order."""
        return list(self._members)

    def __contains__(self, name: object) -> bool:
        return name in self._members

    def __iter__(self) -> Iterator[str]:
        return iter(self._members)

    def __len__(self) -> int:
        return len(self._members)

    def _unknown(self, name: str) -> str:
        likely = [each for word, names in self._likely.items() if word in str(name).casefold() for each in names]
        close = (likely or near_misses(name, self._members))[:3]
        if close:
            return f"No {self.family} is named {name!r}. Did you mean {' or '.join(map(repr, close))}?"
        known = ", ".join(sorted(self._members)) or "none"
        return f"No {self.family} is named {name!r}. Known: {known}."


def near_misses(name: str, known: Iterable[str], *, count: int = 3) -> list[str]:
    """Return up to `count` of the `known` names that are similar to `name`, best match first; case is ignored."""
    by_folded = {str(k).casefold(): str(k) for k in known}
    return [by_folded[k] for k in difflib.get_close_matches(str(name).casefold(), by_folded, count, 0.6)]


def register_function(
    module: dict[str, Any], family: str, fn: Callable[..., Any], override: bool, fn_name: str | None
) -> None:
    """Add `fn` to the globals of a family's module, under its own name or `fn_name`: `rep.modify.register(fn)`.

    Raises:
        ValueError: `fn` is not a function, or the name is not an identifier, or taken while `override` is False.
    """
    if not callable(fn):
        raise ValueError(f"{family}.register: {fn!r} is not a function")
    name = fn_name or getattr(fn, "__name__", type(fn).__name__)
    if not name.isidentifier():
        raise ValueError(f"{family}.register: {name!r} is not a valid name; pass fn_name='a_valid_name'")
    if name in module and not override:
        raise ValueError(f"{family}.register: {name!r} exists; pass override=True to replace it")
    module[name] = fn
    _registered.setdefault(family, set()).add(name)


_registered: dict[str, set[str]] = {}


def registered_functions(family: str) -> list[str]:
    """Return the names of the functions that scripts have registered in a family ("randomizer")."""
    return sorted(_registered.get(family, ()))
