"""A USD stage seen by cameras: exact label AOVs and path-traced pictures, on a CPU or a CUDA GPU, through Warp."""
