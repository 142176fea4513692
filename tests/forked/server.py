"""The process that is forked: it imports what most commands need, and does nothing with it.

    python -m tests.forked.server SOCKET

A fork begins as a new process does: its folder, variables, streams and arguments are those of the client. What it does
not repeat is the import of modules, so tests of that need processes of their own.
"""

import atexit
import contextlib
import ctypes
import gc
import importlib
import json
import os
import pkgutil
import runpy
import select
import signal
import socket
import sys
from typing import Any

from tests.forked.client import EXECUTABLE, NUMBER, STREAMS

MODULES = (
    "usdsdg.cli.app", "usdsdg.functional", "usdsdg.orchestrator", "usdsdg.create", "usdsdg.modify",
    "usdsdg.capture", "usdsdg.writers.formats", "usdsdg.verify.verify", "usdsdg.inspect", "usdsdg.scenarios.jobs",
    "trimesh", "newton",
)  # fmt: skip
# All of their modules, of which scenes need some or others.
ENGINES = ("usdsdg_render", "usdsdg_physics")


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
    """Do what `python ARGUMENTS` does."""
    kind, *rest = arguments
    if kind == "-m":
        sys.argv, sys.path[0] = rest, os.getcwd()
        runpy.run_module(rest[0], run_name="__main__", alter_sys=True)
    elif kind == "-c":
        sys.argv, sys.path[0] = ["-c", *rest[1:]], ""
        exec(compile(rest[0], "<string>", "exec"), vars(sys.modules["__main__"]))
    else:
        sys.argv, sys.path[0] = arguments, os.path.dirname(os.path.abspath(kind))
        runpy.run_path(kind, run_name="__main__")


def keep_libraries() -> None:
    """Leave the modules of libraries whole when a fork ends, which takes ten times as long as the rest of its end.

    Our own are taken apart as in any process.
    """
    ours = ("__main__", "tests", "usdsdg", *ENGINES, *sys.stdlib_module_names)
    for name in [name for name in sys.modules if name.partition(".")[0] not in ours]:
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(sys.modules.pop(name)))


def main() -> None:
    # Threads are not forked, so that none may be started here; OpenBLAS alone starts its own again.
    os.environ["PXR_WORK_THREAD_LIMIT"] = "1"
    gc.disable()
    for name in MODULES:
        importlib.import_module(name)
    for name in ENGINES:
        for module in pkgutil.walk_packages(importlib.import_module(name).__path__, f"{name}."):
            importlib.import_module(module.name)
    atexit.register(keep_libraries)  # as the first one, which runs last
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
