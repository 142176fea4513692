"""Replicator scripts as YAML files, in the form of docs/yaml.md. Mirrors `omni.replicator.replicator_yaml`."""

from usdsdg.replicator_yaml.errors import ParserError
from usdsdg.replicator_yaml.script import parse, run_file

__all__ = ["ParserError", "parse", "run_file"]
