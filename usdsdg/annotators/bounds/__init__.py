"""What bounds a prim: the hulls of its points, and of the balls around points and along curves."""
