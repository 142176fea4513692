"""What the two generations of Isaac Sim's prim wrappers share: arrays, paths, poses, bodies and materials of prims."""
