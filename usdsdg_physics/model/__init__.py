"""Build a Newton model of a scene: mass properties, shapes, collision pipeline, solver, kernels."""
