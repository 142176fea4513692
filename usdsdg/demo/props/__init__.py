"""Demo props, one module per environment, and their textures."""
