"""Places for objects on surfaces and in volumes, without collisions. Knows triangles and nothing of the graph.

`solid` is what collides, `touching` the test, `surface` and `volume` say where candidates lie, `places` chooses among
them.
"""
