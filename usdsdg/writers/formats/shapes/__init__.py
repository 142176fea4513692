"""Shapes that several forms write: projected points, cuboids, poses, masks, outlines, drawings."""
