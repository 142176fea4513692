"""Read prims, hierarchy and time codes of a stage."""
