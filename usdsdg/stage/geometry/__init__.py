"""Geometry on the stage: triangles, skinning, shape meshes, point instancers, pixel masks."""
