"""Ask the server for a fork with the arguments, folder, variables and streams of this process, and end as it does.

A file of its own that imports little: `python -I -S client.py SOCKET ARGUMENTS...` stands in for `python ARGUMENTS...`.
Signals that ask a process to end are passed on to the fork; SIGKILL ends it, too.
"""

import contextlib
import json
import os
import signal
import socket
import sys

STREAMS = 3  # input, output, errors
NUMBER = 32  # bytes of a number that the server tells
EXECUTABLE = "USDSDG_TESTS_PYTHON"  # variable with what forks start programs with
PASSED_ON = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def ask(server, arguments, folder, streams, variables=os.environ):
    """Ask for a fork; return the connection, over which the server tells what `told` returns.

    The server kills the fork when this end of the connection is closed, as by a time limit.
    """
    connection = socket.socket(socket.AF_UNIX)
    connection.connect(str(server))
    data = json.dumps({"arguments": arguments, "folder": folder, "variables": dict(variables)}).encode()
    socket.send_fds(connection, [f"{len(data):8}".encode()], streams)
    connection.sendall(data)
    return connection


def told(connection):
    """Return the next number that the server tells: first the process id of the fork, at its end the exit code.

    Raises:
        ValueError: the server is gone.
    """
    return float(connection.recv(NUMBER, socket.MSG_WAITALL))


def main() -> int:
    signal.pthread_sigmask(signal.SIG_BLOCK, PASSED_ON)
    connection = ask(sys.argv[1], sys.argv[2:], os.getcwd(), range(STREAMS))
    _pass_on_signals(int(told(connection)))
    code = int(told(connection))
    if code < 0:
        if -code in PASSED_ON:
            signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    return code


def _pass_on_signals(fork: int) -> None:
    def pass_on(number: int, _: object) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(fork, number)

    for number in PASSED_ON:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, pass_on)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, PASSED_ON)


if __name__ == "__main__":
    sys.exit(main())
