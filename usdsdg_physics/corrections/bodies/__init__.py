"""Corrections of bodies: flight, rest, sleep, limits of speed, and locked axes."""
