"""`isaacsim.replicator.behavior.utils`: exposed variables, poses, and assets to be dropped."""
