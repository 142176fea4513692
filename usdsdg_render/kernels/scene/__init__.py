"""Ray queries, hits, surfaces and textures of the scene."""
