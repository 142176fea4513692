"""Errors of Replicator YAML files, with file and line."""

from typing import NoReturn

import yaml

from usdsdg.errors import ConfigError


class ParserError(ConfigError):
    """A Replicator YAML file cannot be read, or one of its calls fails; the message begins with file and line."""


def fail(node: yaml.Node, problem: str, *, cause: BaseException | None = None) -> NoReturn:
    """Raise a `ParserError` with the file and line of `node`."""
    mark = node.start_mark
    raise ParserError(f"Error parsing {mark.name}, line {mark.line + 1}: {problem}") from cause
