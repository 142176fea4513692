"""Corrections of contacts: adding missing ones, the energy of impacts, and contact reports."""
