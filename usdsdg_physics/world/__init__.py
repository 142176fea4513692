"""The running simulation: states, substeps, kinematic motion."""
