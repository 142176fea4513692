"""Transforms of prims: reading them, writing poses into the xform ops that prims have, pivots, look-at."""
