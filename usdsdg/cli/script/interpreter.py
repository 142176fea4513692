"""What a script sees as its own of the interpreter: `__main__`, sys.argv, sys.path, and variables for its processes."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from usdsdg.session.script_processes import MODULES, OPTIONS


@contextmanager
def interpreter_restored() -> Iterator[None]:
    """Restore it after a script, and after what finishes its files, for which `__main__` is the script still.

    What follows in this process, such as another part of a dataset, would be taken for that script, or import the
    modules beside it.
    """
    main, arguments, path = sys.modules["__main__"], sys.argv, list(sys.path)
    for_children = {name: os.environ.get(name) for name in (MODULES, OPTIONS)}
    try:
        yield
    finally:
        sys.modules["__main__"], sys.argv, sys.path[:] = main, arguments, path
        for name, value in for_children.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
