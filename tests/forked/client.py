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
EXECUTABLE = "USDSDG_TESTS_PYTHON"  # variable with what forks start programs with
DIGITS = 8  # of numbers that are sent
PASSED_ON = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def main() -> int:
    connection = socket.socket(socket.AF_UNIX)
    connection.connect(sys.argv[1])
    asked = {"arguments": sys.argv[2:], "folder": os.getcwd(), "variables": dict(os.environ)}
    data = json.dumps(asked).encode()
    signal.pthread_sigmask(signal.SIG_BLOCK, PASSED_ON)
    socket.send_fds(connection, [f"{len(data):{DIGITS}}".encode()], range(STREAMS))
    connection.sendall(data)
    _pass_on_signals(int(connection.recv(DIGITS, socket.MSG_WAITALL) or 0))
    # The server ends the fork when this end of the connection is closed, as by a time limit.
    code = int(connection.recv(16) or 1)
    if code < 0:
        signal.signal(-code, signal.SIG_DFL) if -code in PASSED_ON else None
        os.kill(os.getpid(), -code)
    return code


def _pass_on_signals(fork: int) -> None:
    def pass_on(number: int, _: object) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(fork, number)

    for number in PASSED_ON:
        if fork and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, pass_on)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, PASSED_ON)


if __name__ == "__main__":
    sys.exit(main())
