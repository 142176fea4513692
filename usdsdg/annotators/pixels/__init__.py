"""The pass over pixels: what annotators compute for each pixel or mask, in kernels, and what they share of it."""
