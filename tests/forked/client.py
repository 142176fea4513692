"""Ask the server for a fork with the arguments, folder, variables and streams of this process, and end as it does.

A file of its own that imports little: `python -I -S client.py SOCKET ARGUMENTS...` stands in for `python ARGUMENTS...`.
"""

import json
import os
import socket
import sys

STREAMS = 3  # input, output, errors
NUMBER = 32  # bytes of a number that the server tells


def ask(server, arguments, folder, streams):
    """Ask for a fork; return the connection, over which the server tells what `told` returns.

    The server kills the fork when this end of the connection is closed, as by a time limit.
    """
    connection = socket.socket(socket.AF_UNIX)
    connection.connect(str(server))
    data = json.dumps({"arguments": arguments, "folder": folder, "variables": dict(os.environ)}).encode()
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
    connection = ask(sys.argv[1], sys.argv[2:], os.getcwd(), range(STREAMS))
    told(connection)
    code = int(told(connection))
    if code < 0:
        os.kill(os.getpid(), -code)
    return code


if __name__ == "__main__":
    sys.exit(main())
