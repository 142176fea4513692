"""Augmentations: functions and kernels that an annotator's array passes through."""
