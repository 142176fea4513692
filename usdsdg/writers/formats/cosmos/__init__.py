"""Clips of pictures for Cosmos Transfer, with a video of each."""
