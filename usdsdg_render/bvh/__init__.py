"""Ray queries against a scene: closest hit and occlusion, with one back end per kind of device.

Eight-wide trees of our own: on a CPU they are walked with vector instructions, on CUDA in compressed form. Only this
package knows the difference.
"""
