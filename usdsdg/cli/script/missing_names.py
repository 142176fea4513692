"""Names that a script uses and usdsdg lacks, said before the script starts rather than after an hour."""

from __future__ import annotations

import ast
import linecache
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from usdsdg.cli.script.certainty import certain, reached
from usdsdg.errors import ConfigError

if TYPE_CHECKING:
    from usdsdg.compat.coverage.used_names import Use

_NAMES = (ast.Name, ast.Attribute, ast.Call, ast.Import, ast.ImportFrom)


def missing_names(script: Path) -> tuple[list[str], list[str]]:
    """Return a line for each missing name: place, text, name, and what to do instead.

    The first list is of those at which the script is sure to fail, since its own code, outside of branches, reads them,
    or calls them where they are out of scope. The second is of those that it or a module beside it may need.
    """
    from usdsdg.compat.coverage.used_names import uses_of

    try:
        uses = uses_of([script])
    except ConfigError:
        return [], []  # a module beside the script is no Python; its import says so, if it happens
    fatal = _first_uses((use for use in uses if use.file == str(script) and _fails(use)), reached)
    possible = _first_uses((use for use in uses if _is_missing(use)), certain)
    named = {use.name for use in fatal}
    return _told(fatal), _told(use for use in possible if use.name not in named)


def _first_uses(uses: Iterable[Use], sure: Callable[[ast.Module], Iterable[ast.AST]]) -> list[Use]:
    """Return the first use of each name on each file's places that `sure` finds, in text order."""
    places: dict[str, set[tuple[int, int]]] = {}
    first: dict[tuple[str, str], Use] = {}
    for use in sorted(uses, key=lambda use: (use.file, use.line, use.column, use.name)):
        if use.file not in places:
            places[use.file] = _places(use.file, sure)
        if (use.line, use.column) in places[use.file]:
            first.setdefault((use.file, use.name), use)
    return list(first.values())


def _told(uses: Iterable[Use]) -> list[str]:
    """Return what to say of each use, each reason once."""
    from usdsdg.compat.coverage.verdicts import verdict

    reasons, lines = {""}, []
    for use in uses:
        text, why = linecache.getline(use.file, use.line).strip(), use.or_near(verdict(use.name).why)
        lacking = "which usdsdg lacks" if _is_missing(use) else "which usdsdg leaves out"
        reason = f": {why}" if why not in reasons else ""
        reasons.add(why)
        lines.append(f"{Path(use.file).name}:{use.line}: `{text}` needs {use.name}, {lacking}{reason}")
    return lines


def _is_missing(use: Use) -> bool:
    from usdsdg.compat.coverage.verdicts import MISSING, verdict

    return verdict(use.name).state == MISSING


def _fails(use: Use) -> bool:
    """Whether the script fails at this use, whatever it has registered or made up to there."""
    from usdsdg.compat.coverage.verdicts import OUT_OF_SCOPE, is_known, verdict

    return (_is_missing(use) and is_known(use.name)) or (use.called and verdict(use.name).state == OUT_OF_SCOPE)


def _places(file: str, sure: Callable[[ast.Module], Iterable[ast.AST]]) -> set[tuple[int, int]]:
    """Return the line and column of every name, attribute and import that `sure` finds in a file.

    Names with more than one meaning, such as those of arguments, are left out.
    """
    try:
        tree = ast.parse(Path(file).read_bytes())
    except (OSError, ValueError, SyntaxError):
        return set()
    unclear = _unclear_names(tree)
    return {
        (node.lineno, node.col_offset)
        for node in sure(tree)
        if isinstance(node, _NAMES) and not unclear.intersection(_root_names(node))
    }


def _unclear_names(tree: ast.Module) -> set[str]:
    """Return the names that are arguments, or assigned more than once, counting imports of one name as one."""
    nodes = list(ast.walk(tree))
    stored = Counter(each.id for each in nodes if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store))
    imports = (alias for each in nodes if isinstance(each, (ast.Import, ast.ImportFrom)) for alias in each.names)
    stored.update({alias.asname or alias.name.partition(".")[0] for alias in imports})
    return {name for name, count in stored.items() if count > 1} | {
        each.arg for each in nodes if isinstance(each, ast.arg)
    }


def _root_names(node: ast.AST) -> Iterator[str]:
    """Yield the name that a chain of attributes or calls begins with."""
    while isinstance(node, (ast.Attribute, ast.Call)):
        node = node.func if isinstance(node, ast.Call) else node.value
    if isinstance(node, ast.Name):
        yield node.id
