"""Subtrees of prim paths given as strings."""

from bisect import bisect_left


def paths_below(ordered: list[str], root: str) -> list[str]:
    """Return those of the sorted paths that are `root` itself or below it."""
    at = bisect_left(ordered, root)
    itself = ordered[at : at + 1] if at < len(ordered) and ordered[at] == root else []
    # "0" is the character after "/".
    return itself + ordered[bisect_left(ordered, root + "/") : bisect_left(ordered, root + "0")]
