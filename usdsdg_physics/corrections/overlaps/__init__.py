"""Corrections of bodies that overlap: how fast they are pushed apart, and what is squeezed between others."""
