"""The scene in device memory, and launches of kernels."""
