"""A USD stage in motion: UsdPhysics on the stage, Newton underneath, poses and velocities back on the prims."""
