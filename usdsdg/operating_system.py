"""What operating systems do differently, each call with what stands for it where there is none.

No other module names a call that only some systems have.
"""

from __future__ import annotations

import _thread
import ctypes
import errno
import os
import shutil
import signal
import sys
import threading
import time
import weakref
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TextIO

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None
try:
    import msvcrt
except ImportError:  # all others
    msvcrt = None
try:
    import resource
except ImportError:  # Windows
    resource = None

IS_WINDOWS = os.name == "nt"
# Descriptors of `os.open` translate line ends on Windows, unless told.
BINARY = getattr(os, "O_BINARY", 0)
# Far behind the end of any file: Windows locks bytes, and those that are locked cannot be read.
_LOCKED_BYTE = 1 << 40
_TOKEN = os.urandom(4).hex()
# A bit of the mode of a console of Windows: it obeys sequences of control characters.
_VIRTUAL_TERMINAL = 4


def usable_cores() -> int:
    """Return how many CPU cores this process may use: of all cores where the system does not say."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def hold_standard_descriptors() -> None:
    """Open the null device in the place of standard input, output and error, as far as they are closed.

    The next files that are opened would have their numbers, and libraries print into 1 and 2.
    """
    descriptor = os.open(os.devnull, os.O_RDWR)
    while descriptor <= 2:  # each is the lowest that is free
        descriptor = os.open(os.devnull, os.O_RDWR)
    os.close(descriptor)


def is_importing_main_again() -> bool:
    """Return whether multiprocessing has started this process without a fork, and imports the program's file now.

    It does so to have the functions of that file; what the file runs at its top level runs here once more.
    """
    module = sys.modules.get("multiprocessing.process")
    return module is not None and getattr(module.current_process(), "_inheriting", False)


def around_fork(*, before: Callable[[], None] | None = None, in_child: Callable[[], None] | None = None) -> None:
    """Have functions called when this process forks, until it ends; nothing where processes do not fork."""
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(before=before or _nothing, after_in_child=in_child or _nothing)


def wait_for_other_threads(seconds: float) -> None:
    """Wait until no other thread of this process runs, at most so long; not at all where the system does not tell."""
    end, own = time.monotonic() + seconds, threading.get_native_id()
    while any(state == "R" for number, state in _thread_states() if number != own) and time.monotonic() < end:
        time.sleep(0.001)


def _thread_states() -> list[tuple[int, str]]:
    """Return the number of each thread of this process and the letter of its state; [] where there is no /proc."""
    states = []
    try:
        numbers = os.listdir("/proc/self/task")
    except OSError:
        return []
    for number in numbers:
        try:
            line = Path(f"/proc/self/task/{number}/stat").read_text()
        except OSError:
            continue  # it has ended meanwhile
        states.append((int(number), line.rpartition(")")[2].split()[0]))
    return states


def process_name() -> str:
    """Return a name that no other process has, for files that several may make at once.

    In containers, and on other machines that see the same folder, processes may have the same number.
    """
    return f"{os.getpid()}-{_TOKEN}"


def removed_with(owner: object, folder: Path, held: int | None = None) -> Callable[[], object]:
    """Remove a folder together with an object, or at the end of this process; forks of the process leave it.

    held: a descriptor of the folder, which is closed then.

    Returns a function that removes it now.
    """
    return weakref.finalize(owner, _remove_unless_copied, folder, held, os.getpid())


def _remove_unless_copied(folder: Path, held: int | None, process: int) -> None:
    if os.getpid() == process:
        shutil.rmtree(folder, ignore_errors=True)
    if held is not None:
        os.close(held)


def _nothing() -> None:
    pass


def lock(descriptor: int, *, shared: bool = False, wait: bool = True) -> None:
    """Lock an open file for this process; closing it, or the end of the process, unlocks it.

    shared: several processes may have it; nothing is locked on Windows then.

    Raises:
        OSError: another process has it, and `wait` is False.
    """
    if fcntl is not None:
        fcntl.flock(descriptor, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | (0 if wait else fcntl.LOCK_NB))
    elif msvcrt is not None and not shared:
        windows: Any = msvcrt
        os.lseek(descriptor, _LOCKED_BYTE, os.SEEK_SET)
        try:
            while not _locked_on_windows(windows, descriptor, wait=wait):
                pass
        finally:
            os.lseek(descriptor, 0, os.SEEK_SET)


def _locked_on_windows(windows: Any, descriptor: int, *, wait: bool) -> bool:
    """Try to lock; return False where Windows gave up waiting, which it does after ten seconds."""
    try:
        windows.locking(descriptor, windows.LK_LOCK if wait else windows.LK_NBLCK, 1)
    except OSError as error:
        if wait and error.errno == errno.EDEADLK:
            return False
        raise
    return True


def hold_folder(folder: Path, *, wait: bool) -> int:
    """Lock a folder for this process, and return the descriptor of which closing unlocks it, as `lock`.

    Processes that are forked from this one hold it, too.

    Raises:
        OSError: it is gone, is no folder, or `wait` is False and another process has it; or the system, or that of the
            files, locks no folders, as Windows.
    """
    descriptor = os.open(folder, os.O_RDONLY | getattr(os, "O_DIRECTORY", 0) | getattr(os, "O_NOFOLLOW", 0))
    try:
        lock(descriptor, wait=wait)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor


def name_if_free(part: Path, path: Path) -> bool:
    """Give a file another name unless that is taken; return whether it was free. The first name may stay.

    Raises:
        OSError: the file system cannot do so at once.
    """
    try:
        if IS_WINDOWS:
            part.rename(path)  # which replaces nothing there
        else:
            os.link(part, path)
    except FileExistsError:
        return False
    return True


def sync_file(path: Path) -> None:
    """Wait until a file, or the names in a folder, are on the disk; Windows opens no folders, and syncs names itself.

    Raises:
        OSError: the disk failed.
    """
    is_folder = path.is_dir()
    if is_folder and IS_WINDOWS:
        return
    descriptor = os.open(path, os.O_RDONLY if is_folder else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def sync_file_system(folder: Path) -> bool:
    """Wait until all that was written to the file system of a folder is on the disk; False where that is not known.

    Raises:
        OSError: the disk failed.
    """
    syncfs = _syncfs()
    if syncfs is None:
        return False
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        if syncfs(descriptor):
            number = ctypes.get_errno()
            raise OSError(number, os.strerror(number))
    finally:
        os.close(descriptor)
    return True


@cache
def lacks_inodes(folder: Path) -> bool:
    """Return whether the file system of a folder takes no more files, whatever room it has for their bytes.

    False where it does not count them, as on Windows.

    Raises:
        OSError: the folder is not there.
    """
    if not hasattr(os, "statvfs"):
        return False
    found = os.statvfs(folder)
    return found.f_files > 0 and found.f_favail == 0


def _syncfs() -> Any:
    """Return the call of Linux, which Python does not have; None on other systems."""
    if not sys.platform.startswith("linux"):
        return None
    return getattr(ctypes.CDLL(None, use_errno=True), "syncfs", None)


def obeys_terminal_sequences(terminal: TextIO) -> bool:
    """Return whether a terminal interprets ANSI control sequences; on Windows they are enabled first."""
    if not IS_WINDOWS:
        return os.environ.get("TERM") != "dumb"
    windows: Any = msvcrt
    console = ctypes.WinDLL("kernel32")  # pyright: ignore[reportAttributeAccessIssue] - which only Windows has
    handle, mode = ctypes.c_void_p(windows.get_osfhandle(terminal.fileno())), ctypes.c_ulong()
    if not console.GetConsoleMode(handle, ctypes.byref(mode)):
        return False
    return bool(console.SetConsoleMode(handle, mode.value | _VIRTUAL_TERMINAL))


def may_open(descriptor: int) -> bool:
    """Return whether this process may have files open up to a descriptor; its own limit is raised if need be.

    What shells and desktops begin with is often 256 or 1,024, and far below what the system lets a process ask for.
    """
    if resource is None:
        return True
    own, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    if own == resource.RLIM_INFINITY or descriptor < own:
        return True
    wanted = 2 * descriptor if most == resource.RLIM_INFINITY else min(2 * descriptor, most)
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, most))
    except (OSError, ValueError):  # macOS has another limit beside it
        return False
    return descriptor < wanted


def has_ended(pid: int) -> bool:
    """Return whether no process of this machine has a number any more; False where that is not known."""
    if IS_WINDOWS:  # where a signal of 0 would end it
        return False
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):
        pass
    return False


def numbers_of_processes() -> str:
    """Return what tells who numbers the processes: this boot of the machine, and the container; "" if not known."""
    try:
        return f"{Path('/proc/sys/kernel/random/boot_id').read_text().strip()} {os.readlink('/proc/self/ns/pid')}"
    except OSError:
        return ""


def path_of_descriptor(descriptor: int) -> str:
    """Return the path of an open file or folder; an empty one where the system does not tell it."""
    try:
        return os.readlink(f"/proc/self/fd/{descriptor}")
    except OSError:
        return ""


def home_folder() -> Path | None:
    """Return the home folder of the user; None without HOME for a user without an account, as in containers."""
    try:
        return Path.home()
    except RuntimeError:
        return None


def memory_of_process() -> dict[str, int]:
    """Return bytes by name: resident `rss`; on Linux also mapped `vms`, and `uss` that no other process shares.

    On macOS `rss` is the largest so far; on Windows nothing is known.
    """
    status = Path("/proc/self/status")
    if not status.exists():
        return _largest_resident_set()
    sizes, private = _kilobytes(status), _kilobytes(Path("/proc/self/smaps_rollup"))
    return {
        "rss": sizes["VmRSS"] * 1024,
        "vms": sizes["VmSize"] * 1024,
        "uss": (private["Private_Clean"] + private["Private_Dirty"]) * 1024,
    }


def _kilobytes(file: Path) -> dict[str, int]:
    """Return the entries "Name:  123 kB" of a file below /proc."""
    rows = [line.split() for line in file.read_text(encoding="utf-8").splitlines()]
    return {row[0].rstrip(":"): int(row[1]) for row in rows if len(row) == 3 and row[2] == "kB"}


def _largest_resident_set() -> dict[str, int]:
    if resource is None:
        return {}
    largest = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return {"rss": largest if sys.platform == "darwin" else largest * 1024}


def interrupt_main_thread(number: int) -> None:
    """Let the main thread handle a signal, at once also where it sleeps; without a handler nothing happens.

    On Windows a sleep ends first.
    """
    if not callable(signal.getsignal(number)):
        return
    if hasattr(signal, "pthread_kill") and (thread := threading.main_thread().ident) is not None:
        signal.pthread_kill(thread, number)
    else:
        _thread.interrupt_main(signal.Signals(number))
