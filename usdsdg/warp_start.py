"""The start of Warp without messages of its own: none about each module that it loads, and none of a missing driver."""

from __future__ import annotations

import ctypes
import logging
import os
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

from usdsdg.errors import OutputNotWritable
from usdsdg.kernels.cache import compile_what_is_damaged
from usdsdg.parallel import load_on_cpu

# Of a library that has no logger for it: C code prints this line, to the descriptor of standard error.
_NO_DRIVER = b"Warp CUDA warning: Could not find or load the NVIDIA CUDA driver."
_DRIVERS = {"linux": ("libcuda.so", "libcuda.so.1"), "win32": ("nvcuda.dll",)}
_NVIDIA = "0x10de"  # the vendor, as PCI devices tell it
_DISPLAY = "0x03"  # the class of display and 3D controllers begins so
_finding = threading.Lock()


def quiet_warp() -> None:
    """Turn off Warp's messages about modules that it loads, and about a driver that a machine without GPU lacks."""
    import warp

    warp.config.log_level = logging.WARNING
    compile_what_is_damaged()
    _start_without_driver()


def start_warp() -> None:
    """Initialize Warp.

    Raises:
        OutputNotWritable: its folder of compiled kernels cannot be made.
    """
    import warp

    try:
        warp.init()
    except OSError as error:
        raise OutputNotWritable(
            f"the folder of compiled kernels cannot be made: {error}. Name another: export WARP_CACHE_PATH=FOLDER"
        ) from error


def loaded_on_cpu(find: Callable[[], Any]) -> Any:
    """Return the kernel that `find` imports, loaded for the CPU; threads wait for the one that compiles or loads it.

    It takes seconds the first time, and a thread cannot do it once the program is ending.
    """
    with _finding:
        quiet_warp()  # where nothing is rendered, it has not started
        kernel = find()
    load_on_cpu(kernel)
    return kernel


def known_device(name: str) -> str:
    """Return what Warp calls the device of a name, as "cuda:0" for "cuda".

    Raises:
        ValueError: there is no such device; the message lists those that there are.
    """
    quiet_warp()
    import warp

    try:
        # Without a driver Warp prints errors each time that it looks for the current device.
        if name == "cuda" and not warp.is_cuda_available():
            raise ValueError("no GPU can be used")
        return warp.get_device(name).alias
    except (ValueError, RuntimeError) as error:
        known = ", ".join(each.alias for each in warp.get_devices())
        raise ValueError(f"{error}. Devices here: {known}.") from error


@cache
def has_cuda_driver() -> bool:
    """Return whether the library of NVIDIA's driver can be loaded; True on systems for which Warp looks for none."""
    names = _DRIVERS.get(sys.platform)
    return names is None or any(_loads(name) for name in names)


def cuda_driver_version() -> tuple[int, int] | None:
    """Return the newest CUDA that the driver supports, as (12, 4); None where no driver can be loaded."""
    for name in _DRIVERS.get(sys.platform, ()):
        if _loads(name):
            number = ctypes.c_int()
            if ctypes.CDLL(name).cuDriverGetVersion(ctypes.byref(number)) == 0:
                return number.value // 1000, number.value % 1000 // 10
    return None


def has_nvidia_gpu() -> bool:
    """Return whether Linux lists a GPU of NVIDIA, with a driver or without; False where that is not known."""
    return any(
        _text(device / "vendor") == _NVIDIA and _text(device / "class").startswith(_DISPLAY)
        for device in Path("/sys/bus/pci/devices").glob("*")
    )


@cache
def _start_without_driver() -> None:
    """Initialize Warp where there is no driver, without its line about that; with one, leave it to the first use.

    A machine that has a GPU but no driver keeps the line: it is what its user should know.
    """
    if has_cuda_driver() or has_nvidia_gpu():
        return
    with _lines_held_back(_NO_DRIVER):
        start_warp()


@contextmanager
def _lines_held_back(start: bytes) -> Iterator[None]:
    """Hold back what is written to the descriptor of standard error, then write it but for lines that begin so."""
    _flush_stderr()
    try:
        real = os.dup(2)
    except OSError:  # closed
        yield
        return
    try:
        file = tempfile.TemporaryFile()  # noqa: SIM115 - closed below
    except OSError:  # no folder of temporary files can be written to, as where the disk of the system is full
        os.close(real)
        yield
        return
    with file as held:
        os.dup2(held.fileno(), 2)
        try:
            yield
        finally:
            _flush_stderr()
            os.dup2(real, 2)
            os.close(real)
            held.seek(0)
            with suppress(OSError):  # stderr may be a pipe without a reader
                for line in held:
                    if not line.startswith(start):
                        os.write(2, line)


def _flush_stderr() -> None:
    """Write what `sys.stderr` holds back, where a program without a console has one, and it can be flushed."""
    flush = getattr(sys.stderr, "flush", None)
    with suppress(OSError, ValueError):  # its reader has gone, or it is closed
        if flush is not None:
            flush()


def _loads(name: str) -> bool:
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="ascii").strip()
    except OSError:
        return ""
