"""Scene queries: overlap and ray cast."""
