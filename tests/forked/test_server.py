"""Forks end as processes do."""

from __future__ import annotations

from pathlib import Path

from tests.forked import run

LEFT_BEHIND = """
import threading
from usdsdg.session import session

def many():
    while True:
        session.current().orchestrator

threading.Thread(target=many, daemon=True).start()
"""


def test_daemon_threads_find_modules_whole_until_they_end(tmp_path: Path) -> None:
    for _ in range(5):  # where modules were emptied while threads run, 17 of 20 programs told of it
        done = run(["-c", LEFT_BEHIND], cwd=tmp_path)
        assert done.returncode == 0
        assert not done.stderr
