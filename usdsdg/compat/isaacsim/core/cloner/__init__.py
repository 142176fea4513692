"""`isaacsim.core.cloner`: copies of a prim, in a grid or anywhere."""

from usdsdg.compat.isaacsim.core.cloner.cloner import Cloner
from usdsdg.compat.isaacsim.core.cloner.grid_cloner import GridCloner

__all__ = ["Cloner", "GridCloner"]
