"""Memory shared between host and device: staging buffers."""
