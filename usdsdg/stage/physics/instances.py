"""Names of what has no prim of its own.

What a PointInstancer makes is `/World/screws[3]`, and `/World/screws[3]/mesh` below it; the second and further convex
parts of a mesh are `/World/cup<1>`, `/World/cup<2>`, ...
"""

import re

_INSTANCE = re.compile(r"(.*)\[(\d+)\](.*)")


def instance_name(instancer: str, index: int, below: str = "") -> str:
    """Return the name of an instance, or of a prim of its prototype at a path `below` the prototype's root."""
    return f"{instancer}[{index}]{below}"


def part_name(collider: str, part: int) -> str:
    """Return the name of a convex part of a collider; the first has that of the collider."""
    return f"{collider}<{part}>" if part else collider


def whole(name: str) -> str:
    """Return the name of the collider that a part belongs to, other names as they are."""
    return name.partition("<")[0]


def split_instance(name: str) -> tuple[str, int, str] | None:
    """Return the instancer's path, the index and the path below of an instance's name; None of a prim's path."""
    found = _INSTANCE.fullmatch(whole(name))
    return (found[1], int(found[2]), found[3]) if found else None


def prim_of(name: str) -> str:
    """Return the path of a prim, or of the instancer of an instance."""
    found = split_instance(name)
    return found[0] if found else whole(name)
