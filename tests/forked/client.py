"""Ask the server for a fork with the arguments, folder, variables and streams of this process, and end as it does.

A file of its own that imports little: `python -I -S client.py SOCKET ARGUMENTS...` stands in for `python ARGUMENTS...`.
"""

import json
import os
import socket
import sys

STREAMS = 3  # input, output, errors


def main() -> int:
    connection = socket.socket(socket.AF_UNIX)
    connection.connect(sys.argv[1])
    asked = {"arguments": sys.argv[2:], "folder": os.getcwd(), "variables": dict(os.environ)}
    data = json.dumps(asked).encode()
    socket.send_fds(connection, [f"{len(data):8}".encode()], range(STREAMS))
    connection.sendall(data)
    # The server ends the fork when this end of the connection is closed, as by a time limit.
    code = int(connection.recv(16) or 1)
    if code < 0:
        os.kill(os.getpid(), -code)
    return code


if __name__ == "__main__":
    sys.exit(main())
