"""What scripts with nodes of their own import from `omni.replicator.core.scripts.utils.utils`."""

from typing import Any

from usdsdg.errors import Unsupported
from usdsdg.utils.nodes import auto_connect, create_node

__all__ = ["_disconnect", "auto_connect", "create_node"]


def _disconnect(*_: Any) -> None:
    """Not available: nodes are not wired, they run in the order of the script."""
    raise Unsupported(
        "utils._disconnect: nodes run in the order of the script and have no wires to take away; leave the node out"
    )
