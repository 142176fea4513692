"""Everything that runs per pixel or per ray. Kernels are pure: arrays in, arrays out, no prims and no files."""
