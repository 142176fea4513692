"""Numbers in YAML files as YAML 1.2 and JSON have them."""

import re

import yaml


class NumbersLoader(yaml.SafeLoader):
    """YAML 1.2 numbers: `1e-3` is a number, which YAML 1.1 reads as text."""


NumbersLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"),
    list("-+0123456789."),
)
