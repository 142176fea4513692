"""Read UsdPhysics from a stage into plain records in SI units."""
