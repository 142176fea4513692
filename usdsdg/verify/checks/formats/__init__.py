"""Checks of what one dataset format has, and no other."""
