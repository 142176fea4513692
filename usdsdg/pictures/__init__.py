"""Pictures to look at: labels drawn over images, and what annotators hold as images."""
