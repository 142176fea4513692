"""Runs commands on files, one JSON line in, one out; the soak runs this in a process of its own."""

import hashlib
import json
import shutil
import sys
import traceback
from pathlib import Path
from typing import Any

from usdsdg.cli.commands.generate import generate
from usdsdg.cli.commands.render import render
from usdsdg.cli.commands.run import run
from usdsdg.cli.part import run_here

COMMANDS = {"render": render, "generate": generate, "run": run}


def main() -> int:
    """Answer requests {"arguments": [command, ...], "output": folder} until the input ends."""
    out = sys.stdout
    sys.stdout = sys.stderr
    for line in sys.stdin:
        request = json.loads(line)
        print(json.dumps(answer(request["arguments"], Path(request["output"]))), file=out, flush=True)
    return 0


def answer(arguments: list[str], output: Path) -> dict[str, Any]:
    """Return the exit code of a command, what it said, a hash of the pictures in its output, and a traceback."""
    shutil.rmtree(output, ignore_errors=True)
    try:
        code, said = run_here(COMMANDS[arguments[0]], arguments[1:])
    except Exception:  # noqa: BLE001 - what would be a traceback on the command line is what is looked for
        return {"code": 1, "said": "", "pictures": "", "traceback": traceback.format_exc()[-1500:]}
    pictures = hashlib.sha256()
    for path in sorted(output.rglob("*.png")):
        pictures.update(path.read_bytes())
    return {"code": code, "said": said[-3000:], "pictures": pictures.hexdigest(), "traceback": ""}


if __name__ == "__main__":
    sys.exit(main())
