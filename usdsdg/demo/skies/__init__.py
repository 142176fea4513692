"""Indoor panoramas for dome lights, computed from rooms that are described as data."""
