"""Capture of one frame: requests of annotators and writers, exposure, labels, and output to writers."""
