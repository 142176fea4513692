"""`omni.physx.bindings`."""
