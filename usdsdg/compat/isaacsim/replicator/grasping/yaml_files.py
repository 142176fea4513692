"""Configurations of grasps as YAML files."""

from __future__ import annotations

import logging
import os
from pathlib import Path
from typing import Any

import yaml

_log = logging.getLogger("usdsdg.script")


def write_yaml_config(file_path: str, config: dict[str, Any], overwrite: bool = False) -> bool:
    """Write a mapping to a file, whose folders are made; return False, with a warning, where a file must stay.

    Raises:
        OSError: the file cannot be written.
    """
    if not file_path or not file_path.strip():
        _log.warning("write_yaml_config: no file is named")
        return False
    file = Path(os.path.expanduser(file_path))
    if file.exists() and not overwrite:
        _log.warning("%s exists and is not overwritten", file)
        return False
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(yaml.safe_dump(config, default_flow_style=False))
    return True


def read_yaml_config(file_path: str) -> dict[str, Any] | None:
    """Return the mapping in a file; None, with a warning, where there is no such file or it holds something else."""
    file = Path(os.path.expanduser(file_path)) if file_path and file_path.strip() else None
    if file is None or not file.is_file():
        _log.warning("there is no configuration file %s", file_path)
        return None
    try:
        found = yaml.safe_load(file.read_text())
    except yaml.YAMLError as error:
        _log.warning("%s cannot be read: %s", file, error)
        return None
    if not isinstance(found, dict):
        _log.warning("%s holds no mapping", file)
        return None
    return found
