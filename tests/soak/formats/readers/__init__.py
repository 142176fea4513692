"""Scripts that read a format with its official tools, in a Python that has these.

Each is run as `PYTHON script.py ROWS.json ARGUMENTS`, and writes what it found, as rows of the soak.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

# Of an environment with the readers; that of the soak may lack them.
PYTHON = "USDSDG_READERS_PYTHON"


def rows_of(script: str, *arguments: object) -> Iterator[tuple[str, str, bool]]:
    """Run a script of this folder, by its name; return its rows, or one about why it ended."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "rows.json"
        command = [os.environ.get(PYTHON, sys.executable), str(Path(__file__).with_name(f"{script}.py")), str(out)]
        ran = subprocess.run(
            [*command, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
        )
        if ran.returncode:
            last = (ran.stdout.strip().splitlines() or ["nothing said"])[-1]
            yield f"{script} of {command[0]}", f"ended with {ran.returncode}: {last}", False
            return
        for what, found, is_right in json.loads(out.read_text()):
            yield what, found, bool(is_right)
