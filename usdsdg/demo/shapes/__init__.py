"""Polygon modeling of the demo assets: boxes, surfaces of revolution, sweeps."""
