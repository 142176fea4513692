"""Sampling of collision-free positions on surfaces and in volumes, independent of the graph.

`solid` has the collision bodies, `collisions` the collision test, `surface` and `volume` sample candidate positions,
`positions` chooses the first free candidate of each object, and `stage_bodies` reads and moves the prims.
"""
