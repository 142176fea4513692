"""Predicates over labels, as in Replicator's `semantic_filter_predicate`.

    predicate   = clause { ("," | ";") clause }        a label passes when any clause selects it
    clause      = type ":" conjunction { "|" conjunction }
    conjunction = literal { "&" literal }
    literal     = [ "!" ] label

Types and labels may contain `*`, which matches any characters: `*:*` selects everything, `class:*` all classes.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from usdsdg.errors import ConfigError

_GRAMMAR = "write 'type : label & !label | label', clauses separated by ',' or ';', with * as a wildcard"


@dataclass(frozen=True)
class _Conjunction:
    """Requires all of `wanted` and none of `unwanted` among a prim's labels of a type."""

    wanted: tuple[re.Pattern[str], ...]
    unwanted: tuple[re.Pattern[str], ...]

    def select(self, labels: Sequence[str]) -> set[str]:
        if any(pattern.fullmatch(label) for pattern in self.unwanted for label in labels):
            return set()
        selected = [{label for label in labels if pattern.fullmatch(label)} for pattern in self.wanted]
        if not all(selected):
            return set()
        # A conjunction of exclusions only selects all labels.
        return set().union(*selected) if selected else set(labels)


@dataclass(frozen=True)
class _Clause:
    semantic_type: re.Pattern[str]
    alternatives: tuple[_Conjunction, ...]


class LabelFilter:
    """A parsed predicate over semantic labels.

    Raises:
        ConfigError: the predicate does not follow the grammar above.
    """

    def __init__(self, predicate: str = "*:*") -> None:
        self.predicate = predicate
        self._clauses = tuple(_clause(text, predicate) for text in re.split(r"[,;]", predicate) if text.strip())
        if not self._clauses:
            raise ConfigError(f"the semantic filter {predicate!r} selects nothing; {_GRAMMAR}")

    def select(self, labels: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
        """Return the labels that pass, by type and in their order; types without any are left out."""
        selected = {}
        for semantic_type, values in labels.items():
            passing = set()
            for clause in self._clauses:
                if clause.semantic_type.fullmatch(semantic_type):
                    passing.update(*(conjunction.select(values) for conjunction in clause.alternatives))
            if passing:
                selected[semantic_type] = [label for label in values if label in passing]
        return selected

    def __repr__(self) -> str:
        return f"LabelFilter({self.predicate!r})"


def _clause(text: str, predicate: str) -> _Clause:
    semantic_type, colon, expression = text.partition(":")
    if not colon or not semantic_type.strip():
        raise ConfigError(f"the clause {text.strip()!r} of the semantic filter {predicate!r} has no type; {_GRAMMAR}")
    alternatives = tuple(_conjunction(part, predicate) for part in expression.split("|"))
    return _Clause(_pattern(semantic_type, predicate), alternatives)


def _conjunction(text: str, predicate: str) -> _Conjunction:
    wanted, unwanted = [], []
    for literal in (part.strip() for part in text.split("&")):
        side = unwanted if literal.startswith("!") else wanted
        side.append(_pattern(literal.removeprefix("!"), predicate))
    return _Conjunction(tuple(wanted), tuple(unwanted))


def _pattern(text: str, predicate: str) -> re.Pattern[str]:
    text = text.strip()
    if not text or any(character in text for character in "!:()"):
        raise ConfigError(f"{text!r} is not a label or type in the semantic filter {predicate!r}; {_GRAMMAR}")
    return re.compile(".*".join(re.escape(piece) for piece in text.split("*")), re.DOTALL)
