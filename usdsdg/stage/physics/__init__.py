"""UsdPhysics and PhysX schemas on a stage: the simulated scene, colliders and rigid bodies."""
