"""The process that is forked: it imports what most commands need, and does nothing with it.

    python -m tests.forked.server SOCKET

A fork begins as a new process does: its folder, variables, streams and arguments are those of the client. What it does
not repeat is the import of modules, so tests of that need processes of their own.
"""

import atexit
import contextlib
import ctypes
import functools
import gc
import importlib
import itertools
import json
import os
import pkgutil
import re
import runpy
import select
import signal
import socket
import sys
from collections.abc import Iterator
from pathlib import Path
from types import FunctionType, ModuleType, SimpleNamespace
from typing import Any

from tests.forked.client import EXECUTABLE, NUMBER, STREAMS

MODULES = (
    "usdsdg.cli.app", "usdsdg.functional", "usdsdg.orchestrator", "usdsdg.create", "usdsdg.modify",
    "usdsdg.capture", "usdsdg.writers.formats", "usdsdg.verify.verify", "usdsdg.inspect", "usdsdg.scenarios.jobs",
    "usdsdg.cli.program", "usdsdg.cli.script.config_file", "usdsdg.cli.script.outcome", "usdsdg.session.remarks",
    "usdsdg.annotators.pixels.look_up_kernels", "usdsdg.annotators.pixels.pixel_runs", "usdsdg.datasets.on_disk",
    "usdsdg.writers.aggregates", "usdsdg.writers.backends.io_queue", "usdsdg.writers.backends.job",
    "trimesh", "newton",
)  # fmt: skip
# All of their modules, of which scenes need some or others.
ENGINES = ("usdsdg_render", "usdsdg_physics")
# Values of modules that hold nothing of a program.
CONSTANT = (FunctionType, type, ModuleType, str, int, float, tuple, frozenset)
LIBRARIES = ("warp", "numpy", "click", "re", "types", "typing", "collections")  # of whose classes no value does, either
OPTION = re.compile("-[BEIOSbdqsuv]+")  # of the interpreter, as multiprocessing gives on to what it spawns
SHARED: list[str] = []
HELD: list[tuple[dict[str, Any], list[str]]] = []


def serve(path: str) -> dict[str, Any]:
    """Fork for each client until the input ends; return, in forks alone, what the client asks for."""
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(path)
    listener.listen()
    os.write(1, b"ready\n")
    while sys.stdin not in select.select([sys.stdin, listener], [], [])[0]:
        connection, _ = listener.accept()
        if os.fork() == 0:
            listener.close()
            return forked(connection)
        connection.close()
    sys.exit()


def forked(connection: socket.socket) -> dict[str, Any]:
    """Fork once more, and return there; the parent tells the client the exit code, or kills the fork if that ends."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    header, streams, *_ = socket.recv_fds(connection, 8, STREAMS)
    if not header:  # the client was killed before it asked
        os._exit(0)
    data = connection.recv(int(header), socket.MSG_WAITALL)
    fork = os.fork()
    if fork:
        tell(connection, fork)
        ended = os.pidfd_open(fork)
        if ended not in select.select([ended, connection], [], [])[0]:
            os.kill(fork, signal.SIGKILL)
        _, status, usage = os.wait4(fork, 0)
        for number in (os.waitstatus_to_exitcode(status), usage.ru_utime + usage.ru_stime):
            tell(connection, number)
        os._exit(0)
    connection.close()
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    return json.loads(data)


def tell(connection: socket.socket, number: float) -> None:
    """Tell a client a number: of the process, then at its end its exit code and its processor seconds."""
    with contextlib.suppress(BrokenPipeError):
        connection.sendall(f"{number:{NUMBER}}".encode())


def reap(*_: object) -> None:
    """Take note of the end of those that wait for forks, so that their time counts as this process's."""
    with contextlib.suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass


def run(arguments: list[str]) -> None:
    """Do what `python ARGUMENTS` does; options of the interpreter are those of the server."""
    kind, *rest = itertools.dropwhile(OPTION.fullmatch, arguments)
    if kind == "-m":
        sys.argv, sys.path[0] = rest, os.getcwd()
        runpy.run_module(rest[0], run_name="__main__", alter_sys=True)
    elif kind == "-c":
        sys.argv, sys.path[0] = ["-c", *rest[1:]], ""
        exec(compile(rest[0], "<string>", "exec"), vars(sys.modules["__main__"]))
    else:
        sys.argv, sys.path[0] = arguments, os.path.dirname(os.path.abspath(kind))
        runpy.run_path(kind, run_name="__main__")


def make_what_all_make() -> None:
    """Make what most programs would make anew, each the same from its modules alone.

    Warp's cache has kernels under their hashes, on which a short program would spend a third of its time.
    """
    import warp as wp

    from usdsdg_physics.world.compile_kernels import prepare_newton
    from usdsdg_render.device.albedo_table import albedo_table
    from usdsdg_render.device.precompile import module_loads, without_bfloat16

    albedo_table()
    # Options are part of a hash. Warp is not asked for the device: it would initialize CUDA, which outlives no fork.
    cpu: Any = SimpleNamespace(is_cuda=False, is_cpu=True)
    for load in module_loads(cpu, everything=True):
        without_bfloat16(load.module)
    prepare_newton()
    with hashes_kept():
        for name in [name for name in sys.modules if name.partition(".")[0] in ("usdsdg", "newton", *ENGINES)]:
            if (module := wp.get_module(name)).kernels:
                module.get_module_hash(1)  # with blocks of one thread, as on a CPU
    for library in ("warp.so", "warp-clang.so"):
        ctypes.CDLL(str(Path(wp.__file__).with_name("bin") / library))


@contextlib.contextmanager
def hashes_kept() -> Iterator[None]:
    """Keep the hashes of functions that are made meanwhile: those of modules Warp forgets where it starts."""
    from warp._src.context import ModuleHasher

    made, kept = ModuleHasher.hash_adjoint, {}

    @functools.wraps(made)
    def known_or_made(hasher: Any, adjoint: Any) -> bytes:
        return kept[adjoint] if adjoint in kept else made(hasher, adjoint)

    def keep(hasher: Any, adjoint: Any) -> bytes:
        return kept.setdefault(adjoint, known_or_made(hasher, adjoint))

    ModuleHasher.hash_adjoint = keep
    yield
    ModuleHasher.hash_adjoint = known_or_made


def note_modules() -> None:
    """Note the modules that are loaded, which all forks share, and what of ours may hold something of a program."""
    for name, module in list(sys.modules.items()):
        if name in ("__main__", "builtins", "sys"):
            continue
        SHARED.append(name)
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(module))
        if name.partition(".")[0] in ("usdsdg", *ENGINES):
            held = vars(module)
            HELD.append((held, [key for key, value in held.items() if not is_constant(key, value)]))


def is_constant(name: str, value: object) -> bool:
    """Tell whether a value of a module stays as it is, and holds nothing of a program."""
    library = type(value).__module__.partition(".")[0]
    return name.startswith("__") or isinstance(value, CONSTANT) or library in LIBRARIES


class KeptModules:
    """Leaves the modules whole that all forks share: to take them apart takes longer than a short program.

    What ours hold goes, as in any process, and so do modules that the fork was the first to load.
    """

    def __del__(self) -> None:
        for name in SHARED:
            sys.modules.pop(name, None)
        for held, keys in HELD:
            for key in keys:
                held[key] = None


def leave_libraries() -> None:
    """Have the process end without the destructors of C++ libraries, which take as long as a short program.

    The GNU C library calls what was registered last first, so that libraries that a fork loads itself still end.
    """
    libc = ctypes.CDLL(None)
    libc.on_exit(libc._exit, None)  # with the exit code
    libc.on_exit(libc.fcloseall, None)


def keep_modules() -> None:
    """Have modules kept where Python begins to take them apart, by which time daemon threads run no more.

    Of what `sys` holds, its prompts are the first to go. While functions of `atexit` run, threads still do.
    """
    sys.ps1 = KeptModules()


def main() -> None:
    atexit.register(keep_modules)  # as the first one, which runs last
    # Threads are not forked, so that none may be started here; OpenBLAS alone starts its own again.
    os.environ["PXR_WORK_THREAD_LIMIT"] = "1"
    gc.disable()
    for name in MODULES:
        importlib.import_module(name)
    for name in ENGINES:
        for module in pkgutil.walk_packages(importlib.import_module(name).__path__, f"{name}."):
            importlib.import_module(module.name)
    make_what_all_make()
    note_modules()
    leave_libraries()
    gc.freeze()  # else every fork walks all of these modules, and copies their memory with that
    gc.enable()
    signal.signal(signal.SIGCHLD, reap)
    asked = serve(sys.argv[1])
    os.chdir(asked["folder"])
    os.environ.clear()
    os.environ.update(asked["variables"])
    sys.executable = os.environ.get(EXECUTABLE, sys.executable)  # for programs that start others
    run(asked["arguments"])


if __name__ == "__main__":
    main()
