"""Correct contacts and bodies where the solver does not: friction, overlaps, impacts, sleeping, stabilization."""
