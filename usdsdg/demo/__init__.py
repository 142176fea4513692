"""Stand-ins made by code for the assets that the object-based job names, so that a first run needs no download.

`root()` gives the folder; below it lie shapes of the same names, sizes and uses as the originals: groceries
with printed labels, props of a warehouse, an office and a hospital, four indoor panoramas and one hall.
"""

from usdsdg.demo.build import root

__all__ = ["root"]
