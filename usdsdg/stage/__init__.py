"""The USD stage and what can be said of it with pxr and numpy alone."""
