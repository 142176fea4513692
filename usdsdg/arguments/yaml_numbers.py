"""YAML loader that parses numbers as YAML 1.2 and JSON do."""

import re

import yaml


class NumbersLoader(yaml.SafeLoader):
    """A safe loader for which `1e-3` is a number, as in YAML 1.2; YAML 1.1 reads it as text."""


NumbersLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"), list("-+0123456789.")
)
