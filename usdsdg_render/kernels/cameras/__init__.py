"""Pixels to rays, through every lens model."""
