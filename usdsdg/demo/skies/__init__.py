"""Indoor panoramas for dome lights, rendered from rooms that are described as data."""
