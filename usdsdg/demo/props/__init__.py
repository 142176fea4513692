"""The stand-in props, by environment."""
