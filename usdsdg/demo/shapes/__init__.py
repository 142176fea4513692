"""Polygon modeling for the stand-ins: boxes, lathes, sweeps."""
