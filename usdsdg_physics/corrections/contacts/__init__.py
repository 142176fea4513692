"""Corrections of contacts: those that are missing, impacts, and what is told of them."""
