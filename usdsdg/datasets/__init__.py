"""Datasets read back: what the files of each format say about each image."""
