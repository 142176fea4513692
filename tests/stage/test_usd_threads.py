"""Forks of a process in which USD has worked with threads."""

import os
import subprocess
import sys
import textwrap
import threading
import time

import pytest

from usdsdg.operating_system import wait_for_other_threads

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="processes do not fork")

FORK = """
    import os, sys
    from pxr import Usd
    import usdsdg.session.session
    from usdsdg import operating_system

    waited = []
    real = operating_system._thread_states
    operating_system._thread_states = lambda: (waited.append(1), real())[1]
    if (child := os.fork()) == 0:
        stage = Usd.Stage.CreateInMemory()
        del stage
        os._exit(11)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), len(waited) > 0)
"""


def test_a_fork_waits_for_threads_and_its_child_uses_usd():
    command = [sys.executable, "-W", "ignore", "-c", textwrap.dedent(FORK)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.stdout.split() == ["11", "True"], done.stderr


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="the system does not tell what threads do")
def test_waiting_for_other_threads_ends_when_they_rest_or_the_time_is_over():
    stop = threading.Event()
    busy = threading.Thread(target=lambda: [sum(range(20000)) for _ in iter(stop.is_set, True)])
    busy.start()
    started = time.monotonic()
    wait_for_other_threads(0.05)
    assert time.monotonic() - started < 10.0
    stop.set()
    busy.join()
    wait_for_other_threads(60.0)
    assert time.monotonic() - started < 50.0
