"""Write simulated poses and velocities to the stage, and restore what was there."""
