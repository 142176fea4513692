"""Prims by path, and by patterns of which every part between slashes is a regular expression."""

from __future__ import annotations

import re
from collections.abc import Sequence

from pxr import Sdf, Usd

from usdsdg.compat import used_stage
from usdsdg.errors import BadPrim


def prim_of(prim: str | Sdf.Path | Usd.Prim | Usd.SchemaBase) -> Usd.Prim:
    """Return the prim that is given or that has this path; an invalid one if there is none."""
    if isinstance(prim, Usd.SchemaBase):
        return prim.GetPrim()
    return prim if isinstance(prim, Usd.Prim) else used_stage.current_stage().GetPrimAtPath(prim)


def existing_prim(prim: str | Sdf.Path | Usd.Prim | Usd.SchemaBase) -> Usd.Prim:
    """Return the prim.

    Raises:
        BadPrim: there is none.
    """
    found = prim_of(prim)
    if not found:
        raise BadPrim(f"there is no prim at {prim}")
    return found


def matching_paths(pattern: str) -> list[str]:
    """Return the paths of the prims that a path or pattern names, level by level in the order of the stage."""
    stage = used_stage.current_stage()
    if Sdf.Path.IsValidPathString(pattern) and stage.GetPrimAtPath(pattern):
        return [pattern]
    found = [stage.GetPseudoRoot()]
    for part in pattern.strip("/").split("/"):
        name = re.compile(part)
        found = [child for prim in found for child in prim.GetChildren() if name.fullmatch(child.GetName())]
    return [str(prim.GetPath()) for prim in found]


def from_wildcards(expression: str) -> str:
    """Return the regular expression of paths in which "*" and ".*" both stand for any part of a name.

    "?" stands for one character, and "[1-3]" for one of several.
    """
    return expression.replace(".*", "*").replace("?", ".").replace("*", ".*")


def split_paths(paths: str | Sequence[str]) -> tuple[list[str], list[str]]:
    """Return (paths of existing prims, paths of prims to create): one of the two lists is empty.

    Raises:
        ValueError: some exist and others do not, or a pattern matches nothing.
    """
    given = [paths] if isinstance(paths, str) else [str(path) for path in paths]
    found = [matching_paths(path) for path in given]
    missing = [path for path, matches in zip(given, found, strict=True) if not matches]
    invalid = [path for path in missing if not Sdf.Path.IsValidPathString(path)]
    if invalid:
        raise ValueError(f"no prim matches {', '.join(invalid)}")
    if missing and len(missing) != len(given):
        raise ValueError(f"some of the prims exist and others do not: {', '.join(missing)}. Give one kind or the other")
    return [path for matches in found for path in matches], missing
