"""`isaacsim.core.experimental.utils`: helpers for stages, prims, bounds, labels and rotations."""
