"""Robots whose joints have positions: links are placed by forward kinematics, and forces do not act on them."""
