"""Corrections of friction: the coefficients of pairs of materials, where it acts, and surfaces that move."""
