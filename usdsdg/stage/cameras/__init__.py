"""Cameras, lens models and render products on the stage."""
