"""`usdsdg doctor` reports installed packages that do not load as missing."""

import os
import subprocess
import sys

import pytest

from usdsdg_render.path import oidn_denoiser


def doctor(**environment: str) -> str:
    command = [sys.executable, "-m", "usdsdg", "doctor"]
    env = {**os.environ, **environment}
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True, env=env).stdout


@pytest.mark.skipif(oidn_denoiser.lacks_sve(), reason="needs a processor that Open Image Denoise supports")
def test_a_denoiser_that_does_not_load_is_reported_as_missing(tmp_path):
    (tmp_path / "mitsuba_oidn.py").write_text("raise RuntimeError('no thread pool')")
    output = doctor(PYTHONPATH=os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")]))
    assert "Missing:\n  Open Image Denoise is installed but cannot be loaded (no thread pool)" in output
    assert "Nothing is missing" not in output
