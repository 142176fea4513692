"""Cameras: pixels to rays and back, through every lens model."""
