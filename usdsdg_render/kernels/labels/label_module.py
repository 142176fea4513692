"""The Warp module of all label kernels: one module, so that BVH traversal compiles once.

On CUDA each size of blocks is compiled by itself, so all launches have `usdsdg.parallel.CUDA_BLOCK` threads in a block.
"""

import warp as wp

LABELS = wp.get_module(__name__)
