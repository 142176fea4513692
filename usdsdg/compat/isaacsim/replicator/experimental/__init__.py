"""`isaacsim.replicator.experimental`."""
