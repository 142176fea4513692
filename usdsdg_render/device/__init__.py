"""The scene in the memory of the device that renders it, and launching work there."""
