"""Bounding volume hierarchies (BVHs) and ray queries: closest hit and occlusion, with one back end per kind of device.

Trees are eight-wide: on a CPU traversal uses vector instructions, on CUDA nodes are compressed. Only this package knows
the difference.
"""
