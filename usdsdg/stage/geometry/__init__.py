"""Geometry on the stage: triangles, skinning, shape meshes, point-instancer populations, pixel masks."""
