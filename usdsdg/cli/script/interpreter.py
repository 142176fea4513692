"""What a script sees as its own of the interpreter: `__main__`, sys.argv, sys.path and PYTHONPATH."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def interpreter_restored() -> Iterator[None]:
    """Restore it after a script, and after what finishes its files, for which `__main__` is the script still.

    What follows in this process, such as another part of a dataset, would be taken for that script, or import the
    modules beside it.
    """
    main, arguments, path = sys.modules["__main__"], sys.argv, list(sys.path)
    for_children = os.environ.get("PYTHONPATH")
    try:
        yield
    finally:
        sys.modules["__main__"], sys.argv, sys.path[:] = main, arguments, path
        if for_children is None:
            os.environ.pop("PYTHONPATH", None)
        else:
            os.environ["PYTHONPATH"] = for_children
