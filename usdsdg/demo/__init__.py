"""Procedural demo assets for the object-based scenario, so that a first run needs no download.

`root()` returns their folder. Every asset has the file name, size and use of the original: groceries with printed
labels, props of a warehouse, an office and a hospital, four indoor panoramas, and one warehouse hall.
`machine_parts()` returns a folder of parts to put into bins.
"""

from usdsdg.demo.build import machine_parts, root

__all__ = ["machine_parts", "root"]
