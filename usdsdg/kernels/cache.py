"""Warp's cache of compiled kernels, also where a full disk or a crash has damaged it."""

from __future__ import annotations

import functools
import itertools
import os
import shutil
import threading
import zlib
from typing import TYPE_CHECKING, Any

from usdsdg.errors import OutputNotWritable, warn_once

if TYPE_CHECKING:
    import warp as wp

# With less free space [bytes] nothing is compiled: where LLVM finds a disk full, it ends the process.
LEAST_SPACE = 8_000_000
# To load a module: processes that find it damaged at once may each remove what another one has compiled since.
MOST_ATTEMPTS = 3
_made = threading.local()  # `is_there`: whether the module that the thread loads was in the cache, or was compiled
_DAMAGED = "kernels are damaged"  # key of the warning, one for all of them
_OTHER_FOLDER = "name another folder for them: export WARP_CACHE_PATH=FOLDER"


def is_cached(module: wp.Module, device: wp.Device, block: int) -> bool:
    """Return whether the cache has the compiled module; Warp must have been initialized.

    Args:
        block: threads of a block, 1 on a CPU.
    """
    folder = _folder(module, block)
    return folder is not None and os.path.exists(
        os.path.join(folder, module._get_compile_output_name(device, block_dim=block))
    )


def check_space() -> None:
    """Check that there is room for a compiled module.

    Raises:
        OutputNotWritable: there is not.
    """
    import warp as wp

    folder = wp.config.kernel_cache_dir
    if folder is None or not os.access(folder, os.W_OK):
        return
    free = shutil.disk_usage(folder).free
    if free < LEAST_SPACE:
        raise OutputNotWritable(
            f"{folder} has room for {free / 1e6:.1f} MB, too little for compiled kernels. Free space, or "
            f"{_OTHER_FOLDER}"
        )


@functools.cache
def compile_what_is_damaged() -> None:
    """Let Warp compile modules again that are in its cache and cannot be loaded, with a warning.

    Warp loads most modules when a kernel of theirs is launched first, and then goes on to fail, run after run. Those in
    which bits are flipped can be loaded, and then end the process or compute something else: each that is compiled from
    now on has a checksum beside it.
    """
    import warp as wp

    load, make = wp.Module.load, wp.Module._compile

    @functools.wraps(make)
    def compile_or_check(
        module: wp.Module, device: Any = None, output_dir: Any = None, output_name: str | None = None,
        *others: Any, **named: Any,
    ) -> bool:  # fmt: skip
        _made.is_there = False
        is_compiled = make(module, device, output_dir, output_name, *others, **named)
        _made.is_there = True
        if output_dir is not None and output_name is not None and wp.config.cache_kernels:
            check_sum(os.path.join(output_dir, output_name), is_new=is_compiled)
        return is_compiled

    @functools.wraps(load)
    def load_or_compile(
        module: wp.Module, device: Any, block_dim: int | None = None, *others: Any, **named: Any
    ) -> Any:
        for attempt in itertools.count(1):
            try:
                return load(module, device, block_dim, *others, **named)
            except Exception as error:  # of the linker, of JSON or of the driver; compiling tells if it was the file
                block = module.options["block_dim"] if block_dim is None else block_dim
                is_last = attempt == MOST_ATTEMPTS or others or named or not getattr(_made, "is_there", False)
                if isinstance(error, OSError) and (is_last or not isinstance(error, FileNotFoundError)):
                    raise _not_writable(module, block, error) from error
                folder = _folder(module, block)
                if is_last or folder is None:
                    raise
                if is_cached(module, wp.get_device(device), block):  # else another process has removed it meanwhile
                    _remove(folder, error)

    wp.Module.load, wp.Module._compile = load_or_compile, compile_or_check


class Damaged(Exception):
    """A compiled module is not as it was written."""


def check_sum(file: str, *, is_new: bool) -> None:
    """Write the checksum of a compiled module beside it if it is new, else compare it with that, if there is one.

    Raises:
        Damaged: they differ.
    """
    kept = f"{file}.crc32"
    try:
        if not is_new and not os.path.exists(kept):
            return  # of a program without checksums
        with open(file, "rb") as module:
            found = f"{zlib.crc32(module.read()):08x}"
        if is_new:
            own = f"{kept}_p{os.getpid()}"
            with open(own, "w", encoding="ascii") as written:
                written.write(found)
            os.replace(own, kept)
            return
        with open(kept, encoding="ascii", errors="replace") as known:
            differs = known.read() != found
    except OSError:  # it was removed meanwhile, or there is no room; loading the module tells
        return
    if differs:
        raise Damaged("its checksum differs from that of its compilation")


def _folder(module: wp.Module, block: int) -> str | None:
    """Return where a module is in the cache; None where none is used."""
    import warp as wp

    if not wp.config.cache_kernels or wp.config.kernel_cache_dir is None:
        return None
    return os.path.join(wp.config.kernel_cache_dir, module.get_module_identifier(block))


def _remove(folder: str, why: Exception) -> None:
    aside = f"{folder}_damaged_p{os.getpid()}_t{threading.get_ident()}"
    try:
        os.rename(folder, aside)  # removed file by file, other processes would find a part of it
        shutil.rmtree(aside, ignore_errors=True)
    except FileNotFoundError:  # another process has found it damaged as well
        pass
    except OSError as error:
        raise OutputNotWritable(
            f"{folder}: the compiled kernels are damaged ({why}), and cannot be removed: {error.strerror}. Remove that "
            f"folder, or {_OTHER_FOLDER}"
        ) from why
    warn_once(f"compiled kernels were damaged, and are compiled again: {folder} and perhaps others.", key=_DAMAGED)


def _not_writable(module: wp.Module, block: int, error: OSError) -> OutputNotWritable:
    return OutputNotWritable(
        f"compiled kernels cannot be kept in {_folder(module, block)}: {error.strerror or error}. Free space, or "
        f"{_OTHER_FOLDER}"
    )
