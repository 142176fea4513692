"""The families of the API as they are where no script has imported them by the names of Replicator."""

import importlib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from unittest import mock

from usdsdg.arguments.misplaced import FAMILIES, explaining


@contextmanager
def plain_names() -> Iterator[None]:
    """Let errors for missing names call the families `usdsdg.x`, whatever ran in this process before."""
    with ExitStack() as stack:
        for family in FAMILIES:
            module = importlib.import_module(f"usdsdg.{family}")
            if getattr(vars(module).get("__getattr__"), "__module__", "") == "usdsdg.compat.finder":
                stack.enter_context(mock.patch.object(module, "__getattr__", explaining(vars(module))))
        yield
