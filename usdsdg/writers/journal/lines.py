"""The lines of a journal: what each kind of them has, since a journal may have been damaged or tampered with."""

from __future__ import annotations

import json
from typing import Any

FRAME, FILES, STATE, SHARED, FRAMES, COMPLETE = "frame", "files", "state", "shared", "frames", "complete"
LINES, RECIPE, FACTS, SPOOLS, FIRST, FAILED = "lines", "recipe", "facts", "spools", "first", "failed"


def parsed_record(data: bytes) -> dict[str, Any] | None:
    """Return a line of JSON, or None if it is unfinished or damaged."""
    if not data.endswith(b"\n"):
        return None
    try:
        line = json.loads(data)
    except (ValueError, RecursionError):
        return None
    return line if isinstance(line, dict) else None


def parsed(data: bytes) -> dict[str, Any] | None:
    """Return a line of a journal, or None if it is none."""
    line = parsed_record(data)
    return line if line is not None and is_sound(line) else None


def is_sound(line: dict[str, Any]) -> bool:
    """Return whether a line has what lines of journals have."""
    if not are_facts(line.get(FACTS, {})) or not isinstance(line.get(STATE, {}), dict):
        return False
    if not _are_files(line.get(SPOOLS, {})):
        return False
    if FRAMES in line:
        return is_count(line[FRAMES]) and is_count(line.get(FIRST, 0)) and _are_files(line.get(SHARED))
    if FRAME in line:
        if not isinstance(line.get(FAILED, ""), str):
            return False
        return is_count(line[FRAME]) and _are_files(line.get(FILES)) and _are_files(line.get(SHARED, {}))
    return _are_files(line.get(SHARED))


def is_count(value: Any) -> bool:
    """Return whether a value is a whole number, 0 or more."""
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def are_facts(value: Any) -> bool:
    """Return whether a value has the two levels of facts."""
    return isinstance(value, dict) and all(isinstance(each, dict) for each in value.values())


def _are_files(value: Any) -> bool:
    return isinstance(value, dict) and all(
        isinstance(facts, list) and len(facts) == 2 and is_count(facts[0]) and isinstance(facts[1], str)
        for facts in value.values()
    )
