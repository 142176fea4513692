"""How progress is shown: as bars on a terminal, in a notebook."""
