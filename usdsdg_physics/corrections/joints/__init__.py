"""Corrections of joints: links, loads that break them, and distances that ropes and rods keep."""
