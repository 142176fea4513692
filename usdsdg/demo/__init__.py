"""Procedural demo assets for the object-based scenario, so that a first run needs no download.

`root()` returns their folder. Every asset has the file name, size and use of the original: groceries with printed
labels, props of a warehouse, an office and a hospital, four indoor panoramas, one warehouse hall, and a ground with a
grid. `machine_parts()` returns a folder of parts to put into bins, `example_assets()` one of the assets of
`rep.example`, `grid_environment()` the file of the ground alone.
"""

from usdsdg.demo.build import example_assets, grid_environment, machine_parts, root

__all__ = ["example_assets", "grid_environment", "machine_parts", "root"]
