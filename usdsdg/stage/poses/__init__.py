"""Transforms of prims: reading, look-at, and writing into existing xform ops."""
