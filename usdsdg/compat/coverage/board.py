"""Reports of `usdsdg compat`: the names that scripts use, and the board of all known names."""

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from importlib.resources import files

from usdsdg.compat.coverage.used_names import Use
from usdsdg.compat.coverage.verdicts import MISSING, OUT_OF_SCOPE, PARTIAL, STATES, SUPPORTED, verdict

# Groups of names by their prefixes; the first that fits counts.
GROUPS = {
    "Replicator": ("omni.replicator", "annotators.", "writers."),
    "Replicator extensions of Isaac Sim": ("isaacsim.replicator", "omni.behavior", "omni.kit.scripting"),
    "Application, USD and settings": ("omni.usd", "omni.kit", "omni.timeline", "omni.client", "carb", "usdrt"),
    "Physics": ("omni.physx", "omni.physics", "pxr."),
    "Core of Isaac Sim": ("isaacsim.core", "omni.isaac.core"),
    "Cameras, synthetic data and graphs": ("isaacsim.sensors", "omni.syntheticdata", "omni.graph", "omni.isaac.sensor"),
    "Benchmarks, assets and tests": ("isaacsim.benchmark", "isaacsim.storage", "isaacsim.test", "omni.isaac.nucleus"),
    "Other": ("",),
}


@dataclass(frozen=True)
class Row:
    """One name with its verdict, and where it is used ({file: lines})."""

    name: str
    state: str
    why: str
    lines: dict[str, list[int]]


def rows_of(uses: Iterable[Use]) -> list[Row]:
    """Return one row per name, sorted by name."""
    lines: dict[str, dict[str, list[int]]] = {}
    first: dict[str, Use] = {}
    for use in uses:
        lines.setdefault(use.name, {}).setdefault(use.file, []).append(use.line)
        first.setdefault(use.name, use)
    rows = [_row(name, where) for name, where in sorted(lines.items())]
    return [replace(row, why=first[row.name].or_near(row.why)) if row.state == MISSING else row for row in rows]


def known_names() -> list[str]:
    """Return the names of Replicator and those that Isaac Sim's and other public scripts use, sorted."""
    return files("usdsdg.compat.coverage").joinpath("known_names.txt").read_text(encoding="utf-8").split("\n")[:-1]


@cache
def board() -> dict[str, Counter[str]]:
    """Return by group how many of the known names have each state."""
    counts: dict[str, Counter[str]] = {group: Counter() for group in GROUPS}
    for name in known_names():
        counts[_group(name)][verdict(name).state] += 1
    return counts


def board_text() -> str:
    """Return the board as a table of Markdown, with a line of totals below it."""
    counts = board()
    total = sum(counts.values(), Counter())
    lines = [f"| names | {' | '.join(STATES)} |", "|---|" + "---|" * len(STATES)]
    lines += [f"| {group} | {_cells(count)} |" for group, count in counts.items()]
    lines += [f"| **all** | {_cells(total)} |", "", totals(total)]
    return "\n".join(lines)


def totals(count: Counter[str]) -> str:
    """Return the totals as one sentence."""
    in_scope = count[SUPPORTED] + count[PARTIAL] + count[MISSING]
    return (
        f"Of {in_scope} names in scope {count[SUPPORTED]} are supported, {count[PARTIAL]} in part, and "
        f"{count[MISSING]} are missing; {count[OUT_OF_SCOPE]} more are out of scope."
    )


def report_text(rows: Sequence[Row], *, supported: bool = False) -> str:
    """Return the report on scripts: totals, then what is not supported, or everything, with lines and reasons."""
    if not rows:
        return "0 names: nothing of Isaac Sim or Omniverse is imported. Names of `usdsdg` itself are not looked up."
    count = Counter(row.state for row in rows)
    lines = [f"{len(rows)} names: " + ", ".join(f"{count[state]} {state}" for state in STATES)]
    if count[PARTIAL]:
        lines.append("  Partial names work; what is said of them matters only to a script that uses it.")
    for state in (MISSING, PARTIAL, OUT_OF_SCOPE, *([SUPPORTED] if supported else [])):
        for row in (row for row in rows if row.state == state):
            lines.append(f"  {state:12}  {row.name}{f': {row.why}' if row.why else ''}")
            lines += [f"  {'':12}    {file}:{_numbers(numbers)}" for file, numbers in row.lines.items()]
    return "\n".join(lines)


def report_json(rows: Sequence[Row]) -> str:
    """Return the rows and their totals as JSON."""
    count = Counter(row.state for row in rows)
    data = {"totals": {state: count[state] for state in STATES}, "names": [asdict(row) for row in rows]}
    return json.dumps(data, indent=1)


def board_json() -> str:
    """Return the board as JSON: totals by group, and the state of every known name."""
    groups = {group: {state: count[state] for state in STATES} for group, count in board().items()}
    return json.dumps({"groups": groups, "names": [asdict(_row(name, {})) for name in known_names()]}, indent=1)


def _row(name: str, lines: dict[str, list[int]]) -> Row:
    found = verdict(name)
    return Row(name, found.state, found.why, lines)


def _group(name: str) -> str:
    return next(group for group, prefixes in GROUPS.items() if name.startswith(prefixes))


def _cells(count: Counter[str]) -> str:
    return " | ".join(str(count[state]) for state in STATES)


def _numbers(lines: Sequence[int]) -> str:
    return ",".join(map(str, sorted(set(lines))))
