"""UsdLux lights and domes to rows of the light tables."""
