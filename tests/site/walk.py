"""Do what a page says: write its files, run its commands in order, and compare what they print.

A block with a title is a file of that name. A block of bash is run; one of Python without a title is run as a program.
A block `text` after it has lines that must be printed, where `…` stands for anything. A block after the comment
`<!-- not run: REASON -->` is left out, and one after `<!-- needs MODULE -->` where there is no such module.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import warp as wp

from tests import forked
from tests.demo_assets import share_demo_assets
from tests.forked.client import EXECUTABLE

ROOT = Path(__file__).resolve().parents[2]
# What pages read sizes from, such that a page takes seconds: the values that readers see stand behind `:-`.
SIZES = {"FRAMES": "2", "WIDTH": "64", "DROPS": "1", "PARTS": "2", "WORKERS": "2", "STEPS": "2"}
BLOCK = re.compile(
    r"(?:^<!-- not run: (?P<reason>.+?) -->\n+|^<!-- needs (?P<needs>\w+) -->\n+)?"
    r"^(?P<fence>```+)(?P<language>\w*)(?P<rest>[^\n]*)\n(?P<code>.*?)^(?P=fence)$",
    re.MULTILINE | re.DOTALL,
)


@dataclass(frozen=True)
class Block:
    """A code block of a page.

    Attributes:
        reason: Why it is not run; empty if it is.
        title: Name of the file that it is; empty if it is none.
        line: Where it begins in its page.
    """

    language: str
    title: str
    code: str
    reason: str
    line: int


def blocks(page: Path) -> list[Block]:
    """Return the code blocks of a page in order."""
    text = page.read_text(encoding="utf-8")
    return [
        Block(
            match["language"],
            (re.findall(r'title="([^"]*)"', match["rest"]) or [""])[0],
            match["code"],
            match["reason"] or _lack(match["needs"]),
            text.count("\n", 0, match.start("fence")) + 1,
        )
        for match in BLOCK.finditer(text)
    ]


def _lack(module: str | None) -> str:
    return f"there is no {module}" if module and find_spec(module) is None else ""


def kernels() -> str:
    """Return what WARP_CACHE_PATH has to be so that programs share the kernels of this process."""
    wp.init()
    return str(Path(str(wp.config.kernel_cache_dir)).parent)


def environment(folder: Path, python: list[str]) -> dict[str, str]:
    """Return the variables of a reader who has activated an environment with usdsdg, with a home in `folder`.

    python: the command that stands for `python`.
    """
    commands = Path(tempfile.mkdtemp(prefix=".commands", dir=folder))
    for name, arguments in {"usdsdg": ["-m", "usdsdg"], "python": []}.items():
        (commands / name).write_text(f'#!/bin/sh\nexec {shlex.join([*python, *arguments])} "$@"\n')
        (commands / name).chmod(0o755)
    paths = {"PATH": f"{commands}{os.pathsep}{os.environ['PATH']}", "HOME": str(folder), "WARP_CACHE_PATH": kernels()}
    return {**os.environ, **SIZES, **paths, "PYTHONPATH": str(ROOT), "PYTHONWARNINGS": "ignore"}


def walk(page: Path, folder: Path) -> None:
    """Do what a page says in an empty folder.

    Raises:
        AssertionError: a command failed, or did not print what the page says; the message names the line of the page.
    """
    variables = environment(folder, forked.command())
    if hasattr(os, "pidfd_open"):
        variables[EXECUTABLE] = forked.executable()
    # A fork is not the process whose number the shell knows.
    killed = environment(folder, [sys.executable])
    share_demo_assets(folder / ".cache")
    printed = ""
    for block in blocks(page):
        where = f"{page.name}:{block.line}"
        if block.reason:
            continue
        if block.title:
            (folder / block.title).parent.mkdir(parents=True, exist_ok=True)
            (folder / block.title).write_text(block.code, encoding="utf-8")
        elif block.language in ("bash", "python"):
            command = ["bash", "-euo", "pipefail", "-c"] if block.language == "bash" else [*forked.command(), "-c"]
            env = killed if "kill -9" in block.code else variables
            done = subprocess.run(
                [*command, block.code], cwd=folder, env=env, capture_output=True, text=True, timeout=280
            )
            printed = done.stdout + done.stderr
            assert done.returncode == 0, f"{where}: exit code {done.returncode}\n{printed}"
            assert "remark: " not in printed, f"{where}: a remark, as of pictures that are black\n{printed}"
        elif block.language == "text":
            for line in block.code.splitlines():
                pattern = ".*".join(re.escape(part) for part in line.strip().split("…"))
                assert re.search(pattern, printed), f"{where}: {line!r} was not printed, but\n{printed}"
        else:
            raise AssertionError(f"{where}: a block of {block.language or 'no language'} has no title")
