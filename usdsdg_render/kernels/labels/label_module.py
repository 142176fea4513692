"""The Warp module of all label kernels: one module, so that BVH traversal compiles once."""

import warp as wp

LABELS = wp.get_module(__name__)
