"""Kernels of the path tracer and its film."""
