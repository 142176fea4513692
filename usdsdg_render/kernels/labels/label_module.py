"""Label kernels are compiled as one module: apart, each would compile the way of a ray to its hit once more."""

import warp as wp

LABELS = wp.get_module(__name__)
