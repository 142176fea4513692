"""UsdShade, MDL and MaterialX materials to rows of the material table."""
