"""A parsed scene as plain records in SI units: bodies, colliders, shapes, materials."""
