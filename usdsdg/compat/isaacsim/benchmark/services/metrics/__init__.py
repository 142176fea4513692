"""`isaacsim.benchmark.services.metrics`: measurements, and what they are written to."""
