"""Solve the contacts of free bodies with as many threads as a GPU has: pairs, colors, rows, sweeps."""
