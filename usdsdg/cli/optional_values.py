"""Options whose value may be left out, which the library of the command line does not have."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

# By command: option -> the value where none is given.
WITHOUT_VALUE = {"generate": {"--ray": "local"}}


def completed(arguments: Sequence[str]) -> list[str]:
    """Return the arguments of the program with the values that were left out: before another option or a file."""
    options = WITHOUT_VALUE.get(arguments[0], {}) if arguments else {}
    found = []
    for place, argument in enumerate(arguments):
        found.append(argument)
        if argument in options:
            following = arguments[place + 1] if place + 1 < len(arguments) else "-"
            if following.startswith("-") or Path(following).is_file():
                found.append(options[argument])
    return found
