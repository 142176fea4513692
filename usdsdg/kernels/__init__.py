"""Compiled kernels: modules that are loaded or compiled with progress, and Warp's cache of them."""
