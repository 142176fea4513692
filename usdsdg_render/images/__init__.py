"""Image files to textures."""
