"""`omni.physx.scripts`: functions that author physics on a stage."""
