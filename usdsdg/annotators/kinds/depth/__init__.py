"""The depth camera: two eyes, the sensor that matches them, and its outputs."""
