"""`python -m tests` checks everything: style, types, behavior."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from tests import forked
from usdsdg.operating_system import usable_cores

ROOT = Path(__file__).resolve().parent.parent

TYPES = [sys.executable, "-m", "pyright", "--pythonpath", sys.executable]
CHECKS = [
    ("style", [sys.executable, "-m", "ruff", "check", "."]),
    ("format", [sys.executable, "-m", "ruff", "format", "--check", "."]),
    # A process for each CPU and one more, since many tests wait for commands and browsers. The tests of a file stay
    # together, for they share what they have made. Files come in the order of tests/conftest.py: else those with the
    # fewest tests, which take longest, would come last, and one process would be left alone with them. A process that
    # crashes is not started again: pytest-xdist would wait for ever for the tests that it had.
    ("tests", [
        sys.executable, "-m", "pytest", "-n", str(usable_cores() + 1), "--dist", "loadfile", "--no-loadscope-reorder",
        "--max-worker-restart", "0", *sys.argv[1:],
    ]),
]  # fmt: skip


def main() -> int:
    """Run every check, also after one fails; return the number of failures, which is the exit code."""
    failed = []
    with tempfile.TemporaryFile("w+") as report, tempfile.TemporaryDirectory() as compiled:
        # Pyright takes two minutes of one CPU, so it runs beside the tests.
        types = subprocess.Popen(TYPES, cwd=ROOT, stdout=report, stderr=subprocess.STDOUT)
        environment = variables(os.environ, compiled)
        for name, command in CHECKS:
            if name == "tests":
                _prepare_tests(environment)
            _announce(name, command)
            if subprocess.run(command, cwd=ROOT, env=environment).returncode != 0:
                failed.append(name)
        _announce("types", TYPES)
        if types.wait() != 0:
            failed.append("types")
        report.seek(0)
        print(report.read(), end="")
    print("all checks passed" if not failed else f"failed: {', '.join(failed)}")
    return len(failed)


def variables(environment: Mapping[str, str], folder: str) -> dict[str, str]:
    """Return the variables of the checks: where Python may keep no compiled modules, it keeps them in a folder.

    Tests start a thousand processes, and to compile the modules takes each of them longer than most of what it does.
    """
    found = dict(environment)
    if found.pop("PYTHONDONTWRITEBYTECODE", None) is not None:
        found.setdefault("PYTHONPYCACHEPREFIX", folder)
    return found


def is_compiled(environment: Mapping[str, str]) -> bool:
    """Return whether Python has kept tests as pytest has compiled them."""
    return "PYTHONPYCACHEPREFIX" not in environment and any((ROOT / "tests" / "__pycache__").glob("*-pytest-*"))


def _prepare_tests(environment: dict[str, str]) -> None:
    """Do once, on the CPU beside pyright, what else each process that runs tests would do.

    Collecting the tests once compiles their modules; a test that cannot be imported is reported when it runs. The fork
    server imports the product once for all programs that tests fork.
    """
    if not is_compiled(environment):
        command = [sys.executable, "-m", "pytest", "--collect-only", "-qq", *sys.argv[1:]]
        subprocess.run(command, cwd=ROOT, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    if hasattr(os, "pidfd_open"):
        environment[forked.SERVER] = str(forked.start(environment))


def _announce(name: str, command: list[str]) -> None:
    print(f"== {name}: {' '.join(command[1:])}", flush=True)


if __name__ == "__main__":
    sys.exit(main())
