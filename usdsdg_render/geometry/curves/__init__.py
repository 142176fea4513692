"""Curves and points: polylines of curves, and the tubes and spheres that they are drawn as."""
