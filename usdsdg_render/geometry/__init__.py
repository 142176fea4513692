"""UsdGeom gprims to triangles."""
