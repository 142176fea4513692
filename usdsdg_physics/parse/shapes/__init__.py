"""Collision shapes of gprims and meshes: primitives, hulls, convex parts and triangles."""
