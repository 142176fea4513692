"""`isaacsim.replicator.behavior`: scripts on prims that randomize them while the timeline plays."""
