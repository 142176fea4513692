"""Robots whose joints have positions: physics moves those that it simulates, forward kinematics places the others."""
