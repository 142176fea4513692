"""Ray queries against a scene: closest hit and occlusion, with one back end per kind of device.

On a CPU an eight-wide tree of our own is walked with vector instructions; on CUDA Warp's mesh query runs over one
flattened mesh. Only this package knows the difference.
"""
