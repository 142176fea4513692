"""Augmentations of annotator arrays: what they are, and Replicator's built-in ones."""
