"""A bin picking dataset: parts dropped into a bin, seen by several cameras."""
