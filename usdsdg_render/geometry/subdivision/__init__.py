"""Subdivision surfaces: refinement rules, sharpness, and the refined mesh."""
