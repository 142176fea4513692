"""Options whose value may be left out, where what follows may be a file that is not the value."""

from __future__ import annotations

import os
from collections.abc import Sequence

# By command: option -> the value where none is given.
WITHOUT_VALUE = {"generate": {"--ray": "local", "--rerun": "viewer"}, "run": {"--rerun": "viewer"}}
# A file with this ending is the value of an option, and not what the command is about.
VALUES = (".rrd",)
# What comes after a file with one of these belongs to the script.
SCRIPTS = (".py", ".yaml", ".yml")


def completed(arguments: Sequence[str]) -> list[str]:
    """Return the arguments of the program with the values that were left out: before another option or a file."""
    options = WITHOUT_VALUE.get(arguments[0], {}) if arguments else {}
    found = []
    for place, argument in enumerate(arguments):
        if arguments[0] == "run" and argument.endswith(SCRIPTS) and os.path.isfile(argument):
            return [*found, *arguments[place:]]
        found.append(argument)
        if argument in options:
            following = arguments[place + 1] if place + 1 < len(arguments) else "-"
            is_file = os.path.isfile(following) and not following.endswith(VALUES)
            if following.startswith("-") or is_file:
                found.append(options[argument])
    return found
