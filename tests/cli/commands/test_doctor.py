"""`usdsdg doctor` reports installed packages that do not load as missing."""

import os
import subprocess
import sys
from dataclasses import replace

import pytest

from usdsdg.cli.machine_advice import Machine, advice, gpu_line
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


HEALTHY = Machine(
    cores=8, all_cores=8, has_gpu=True, driver=(12, 8), needed_driver=(12, 0), cuda_devices=1, hidden_devices=None,
    has_denoiser=True, cache="/cache", can_write_cache=True, cold_modules=0,
)  # fmt: skip


def test_a_healthy_machine_gets_no_advice():
    assert (gpu_line(HEALTHY), advice(HEALTHY)) == ("", [])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"has_gpu": False, "driver": None}, "no NVIDIA GPU and no driver: everything runs on the CPU"),
        ({"driver": None}, "no driver can be loaded, so everything runs on the CPU. Install NVIDIA's driver"),
        ({"driver": (11, 4)}, "the driver supports CUDA 11.4, and Warp needs 12.0"),
        ({"hidden_devices": ""}, "unset CUDA_VISIBLE_DEVICES"),
        ({}, "docker run --gpus all"),
    ],
)
def test_it_says_why_a_gpu_cannot_be_used_and_what_to_do(changes, said):
    assert said in gpu_line(replace(HEALTHY, cuda_devices=0, **changes))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"cold_modules": 3}, "3 modules of kernels are not compiled yet, which the first run does: usdsdg warmup"),
        ({"can_write_cache": False}, "export WARP_CACHE_PATH=FOLDER"),
        ({"has_denoiser": False}, "pip install 'usdsdg[denoise]'"),
        ({"cuda_devices": 0}, "the GPU is not used"),
        ({"cuda_devices": 0, "has_gpu": False, "driver": None, "cores": 2}, "this process may use 2 of 8 cores"),
        ({"cuda_devices": 0, "has_gpu": False, "driver": None, "cores": 2, "all_cores": 2}, "2 cores render slowly"),
    ],
)
def test_each_thing_that_would_be_faster_is_one_line_with_its_remedy(changes, said):
    (line,) = advice(replace(HEALTHY, **changes))
    assert said in line


def test_kernels_that_are_not_compiled_are_counted(tmp_path):
    assert "usdsdg warmup" in doctor(WARP_CACHE_PATH=str(tmp_path / "empty"))


def test_a_folder_of_kernels_that_cannot_be_made_is_one_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(subprocess.CalledProcessError) as failed:
        doctor(WARP_CACHE_PATH=str(tmp_path / "file" / "below"))
    (line,) = failed.value.stderr.splitlines()
    assert line.startswith("error: the folder of compiled kernels cannot be made")
    assert "export WARP_CACHE_PATH=FOLDER" in line
