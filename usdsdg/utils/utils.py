"""What scripts import from `omni.replicator.core.utils.utils`: all of `rep.utils`, and a part of OmniGraph's."""

from typing import Any

from usdsdg.errors import Unsupported
from usdsdg.utils import *  # noqa: F403  # all that it lists
from usdsdg.utils import __all__ as _of_utils

__all__ = ["_disconnect", *_of_utils]  # pyright: ignore[reportUnsupportedDunderAll]


def _disconnect(*_: Any) -> None:
    """Raise Unsupported: nodes have no connections, they run in the order of the script."""
    raise Unsupported(
        "utils._disconnect: nodes run in the order of the script and have no connections to remove; leave the node out"
    )
