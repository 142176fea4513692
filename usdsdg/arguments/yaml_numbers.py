"""YAML loader that parses numbers as YAML 1.2 and JSON do, and whose only errors are those of YAML."""

import re
from typing import Any

import yaml
from yaml.constructor import ConstructorError

_PREFIX = "tag:yaml.org,2002:"


class NumbersLoader(yaml.SafeLoader):
    """A safe loader for which `1e-3` is a number and `2020-01-31` is text, as in YAML 1.2; YAML 1.1 swaps them."""

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        """Return the value of a node.

        Raises:
            ConstructorError: there is none, as of `!!int ""`, for which PyYAML raises whatever its conversion does.
        """
        try:
            return super().construct_object(node, deep)
        except (ValueError, LookupError, AttributeError, TypeError, OverflowError) as error:
            kind = node.tag.removeprefix(_PREFIX)
            raise ConstructorError(None, None, f"{node.value!r} is no {kind}", node.start_mark) from error


NumbersLoader.add_implicit_resolver(
    f"{_PREFIX}float", re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"), list("-+0123456789.")
)
# The resolvers of the line above are a copy of PyYAML's own.
NumbersLoader.yaml_implicit_resolvers = {
    first: [each for each in resolvers if each[0] != f"{_PREFIX}timestamp"]
    for first, resolvers in NumbersLoader.yaml_implicit_resolvers.items()
}
