"""Functions that scripts with custom nodes import from `omni.replicator.core.scripts.utils.utils`."""

from typing import Any

from usdsdg.errors import Unsupported
from usdsdg.utils.nodes import auto_connect, create_node

__all__ = ["_disconnect", "auto_connect", "create_node"]


def _disconnect(*_: Any) -> None:
    """Raise Unsupported: nodes have no connections, they run in the order of the script."""
    raise Unsupported(
        "utils._disconnect: nodes run in the order of the script and have no connections to remove; leave the node out"
    )
