"""Kernels of the label pass."""
