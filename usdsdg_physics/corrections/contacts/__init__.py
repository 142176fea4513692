"""Corrections of contacts: their coefficients, points and surfaces, and bodies that overlap."""
