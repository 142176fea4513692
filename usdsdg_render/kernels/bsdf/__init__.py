"""Scattering at surfaces."""
