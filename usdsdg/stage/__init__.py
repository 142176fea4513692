"""The USD stage: everything that needs pxr and NumPy only."""
