"""What would make usdsdg faster on a machine, and whether its GPU can be used, each with the command that mends it."""

from __future__ import annotations

from dataclasses import dataclass

from usdsdg.errors import counted

FEW_CORES = 4

Version = tuple[int, int]


@dataclass(frozen=True)
class Machine:
    """What is known of a machine.

    Attributes:
        cores, all_cores: CPUs that this process may use, and those that there are.
        has_gpu: whether a GPU of NVIDIA is listed, with a driver or without.
        driver: the newest CUDA that the driver supports; None: no driver can be loaded.
        needed_driver: what Warp needs.
        cuda_devices: GPUs that Warp can use.
        hidden_devices: CUDA_VISIBLE_DEVICES, None if it is not set.
        has_denoiser: whether Open Image Denoise is installed.
        cache: the folder of kernels. can_write_cache: whether it can be written.
        cold_modules: modules of kernels of the renderer that are not compiled yet.
    """

    cores: int
    all_cores: int
    has_gpu: bool
    driver: Version | None
    needed_driver: Version
    cuda_devices: int
    hidden_devices: str | None
    has_denoiser: bool
    cache: str
    can_write_cache: bool
    cold_modules: int


def gpu_line(machine: Machine) -> str:
    """Return whether a GPU can be used, and if not, why and what to do."""
    if machine.cuda_devices:
        return ""
    if machine.driver is None and machine.has_gpu:
        return (
            "an NVIDIA GPU is here, but no driver can be loaded, so everything runs on the CPU. Install NVIDIA's "
            "driver (on Ubuntu: sudo ubuntu-drivers install); in a container: docker run --gpus all"
        )
    if machine.driver is None:
        return "no NVIDIA GPU and no driver: everything runs on the CPU"
    if machine.driver < machine.needed_driver:
        return (
            f"the driver supports CUDA {_text(machine.driver)}, and Warp needs {_text(machine.needed_driver)}, so "
            "everything runs on the CPU. Update NVIDIA's driver (on Ubuntu: sudo ubuntu-drivers install)"
        )
    if machine.hidden_devices is not None:
        return (
            f"the driver shows no GPU, for CUDA_VISIBLE_DEVICES is {machine.hidden_devices!r}, so everything runs on "
            "the CPU: unset CUDA_VISIBLE_DEVICES"
        )
    return "the driver is here and shows no GPU: everything runs on the CPU. In a container: docker run --gpus all"


def advice(machine: Machine) -> list[str]:
    """Return what would make runs faster or better, each with a command where there is one."""
    found = []
    if not machine.cuda_devices and (machine.has_gpu or machine.driver is not None):
        found.append("the GPU is not used: see devices above")
    if not machine.can_write_cache:
        found.append(
            f"kernels are compiled in every run, for {machine.cache} cannot be written: "
            "export WARP_CACHE_PATH=FOLDER, with a folder that can"
        )
    elif machine.cold_modules:
        found.append(
            counted(machine.cold_modules, "module of kernels is", "modules of kernels are")
            + " not compiled yet, which the first run does: usdsdg warmup"
        )
    if not machine.has_denoiser:
        found.append(
            "path-traced images need more samples without Open Image Denoise, since our own filter leaves the noise of "
            "motion blur and depth of field: pip install 'usdsdg[denoise]'"
        )
    if machine.cores < machine.all_cores and not machine.cuda_devices:
        found.append(
            f"this process may use {machine.cores} of {machine.all_cores} cores: give it more (docker run --cpus, "
            "taskset, the scheduler of the cluster)"
        )
    elif machine.cores < FEW_CORES and not machine.cuda_devices:
        found.append(
            f"{machine.cores} cores render slowly: take smaller pictures and fewer samples while you try things "
            "(--set resolution=[320,240]), and a machine with more cores or a GPU for the dataset"
        )
    return found


def _text(version: Version) -> str:
    return f"{version[0]}.{version[1]}"
