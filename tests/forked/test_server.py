"""Forks end as processes do."""

from __future__ import annotations

import subprocess
import time
from pathlib import Path

import pytest

from tests.forked import run

LEFT_BEHIND = """
import threading
from usdsdg.session import session

def many():
    while True:
        session.current().orchestrator

threading.Thread(target=many, daemon=True).start()
"""
HASHES = """
from warp._src.context import ModuleHasher
from usdsdg.kernels.compilation import kernel_modules
from usdsdg.warp_start import quiet_warp
from usdsdg_render.kernels.labels.label_kernels import label_pixels

quiet_warp()
kept = ModuleHasher.hash_adjoint
for module in [label_pixels.module, *kernel_modules("usdsdg_physics.guards")]:
    assert module.kernels
    found = []
    for ModuleHasher.hash_adjoint in (kept, kept.__wrapped__):
        module.mark_modified()
        found.append(module.get_module_hash(1))
    assert found[0] == found[1]
"""
ENDING = """
import ctypes, sys

ctypes.CDLL(None).printf(b"held back")
sys.exit(3)
"""


def test_hashes_of_kernels_that_are_kept_are_those_that_warp_makes(tmp_path: Path) -> None:
    done = run(["-c", HASHES], cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


def test_what_libraries_hold_back_is_printed_and_the_exit_code_is_told(tmp_path: Path) -> None:
    done = run(["-c", ENDING], cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (3, "held back", "")


def test_daemon_threads_find_modules_whole_until_they_end(tmp_path: Path) -> None:
    for _ in range(5):  # where modules were emptied while threads run, 17 of 20 programs told of it
        done = run(["-c", LEFT_BEHIND], cwd=tmp_path)
        assert done.returncode == 0
        assert not done.stderr


def test_a_program_that_takes_too_long_is_killed(tmp_path: Path) -> None:
    program = "import time\nwhile True:\n    print('goes on', file=open('said', 'a'), flush=True)\n    time.sleep(0.01)"
    said = tmp_path / "said"
    said.touch()
    with pytest.raises(subprocess.TimeoutExpired):
        run(["-c", program], cwd=tmp_path, timeout=1)
    until, before = time.monotonic() + 20, -1
    while said.stat().st_size != before:
        assert time.monotonic() < until
        before = said.stat().st_size
        time.sleep(0.5)


def test_all_of_what_is_printed_comes_back_and_signals_are_told(tmp_path: Path) -> None:
    program = (
        "import os, sys\n"
        "print('a\\r\\n' + 'b' * 300_000, flush=True)\n"
        "print('ö', file=sys.stderr, flush=True)\n"
        "os.kill(os.getpid(), 9)\n"
    )
    done = run(["-c", program], cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (-9, "a\n" + "b" * 300_000 + "\n", "ö\n")
