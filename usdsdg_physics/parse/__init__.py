"""Read UsdPhysics from a stage into a scene of plain records in SI units."""
