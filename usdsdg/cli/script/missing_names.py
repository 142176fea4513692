"""Names that a script uses and usdsdg lacks, said before the script starts rather than after an hour."""

from __future__ import annotations

import ast
import linecache
from pathlib import Path

from usdsdg.cli.script.certainty import certain
from usdsdg.errors import ConfigError


def missing_names(script: Path) -> list[str]:
    """Return one line for each missing name that the script is sure to use: place, text, name, and what to do."""
    from usdsdg.compat.coverage import board
    from usdsdg.compat.coverage.used_names import uses_of
    from usdsdg.compat.coverage.verdicts import MISSING

    try:
        rows = board.rows_of(uses_of([script]))
    except ConfigError:
        return []  # a module beside the script is no Python; its import says so, if it happens
    found = []
    for row in rows:
        for file, lines in row.lines.items() if row.state == MISSING else ():
            sure = sorted(set(lines) & _certain_lines(file))
            if sure:
                text = linecache.getline(file, sure[0]).strip()
                why = f": {row.why}" if row.why else ""
                line = f"{Path(file).name}:{sure[0]}: `{text}` needs {row.name}, which usdsdg lacks{why}"
                found.append((file, sure[0], line))
    return [line for _, _, line in sorted(found)]


def _certain_lines(file: str) -> set[int]:
    try:
        tree = ast.parse(Path(file).read_text(encoding="utf-8"))
    except (OSError, ValueError, SyntaxError):
        return set()
    return {node.lineno for node in certain(tree) if hasattr(node, "lineno")}
