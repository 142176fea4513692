"""All cases of the tests of which CI runs a sample.

python -m tests.soak cases [ARGUMENTS OF PYTEST]
"""

import os
import subprocess
import sys
from pathlib import Path

from tests.sampled_cases import SETTING

TESTS = Path(__file__).parents[1]


def main() -> int:
    files = [str(file) for file in sorted(TESTS.rglob("test_*.py")) if "sampled_cases" in file.read_text()]
    environment = os.environ | {SETTING: "1"}
    return subprocess.call([sys.executable, "-m", "pytest", "-v", *files, *sys.argv[1:]], env=environment)
