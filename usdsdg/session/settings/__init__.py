"""Settings: their store, parts of it as items, and the version of Replicator that one of them names."""
