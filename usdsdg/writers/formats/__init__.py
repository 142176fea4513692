"""The writers and what belongs to their file formats."""
