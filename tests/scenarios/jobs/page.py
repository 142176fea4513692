"""The commands of docs/jobs.md that make a dataset of a folder of meshes."""

from __future__ import annotations

import shlex
from pathlib import Path

ROOT = Path(__file__).parents[3]


def documented(config: str, folder: str) -> list[str]:
    """Return the arguments of the page's command with a configuration file, for `folder` in the place of FOLDER."""
    lines = (ROOT / "docs/jobs.md").read_text(encoding="utf-8").splitlines()
    (line,) = (each for each in lines if each.startswith(f"usdsdg generate {config} --set meshes=FOLDER"))
    arguments = shlex.split(line.replace("FOLDER", folder))[1:]
    return [str(ROOT / each) if each == config else each for each in arguments]
